// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The unit of a drawing's numbers.

#include "drawing/dxf/dxf_file.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

struct DrawingUnit {
  std::string name;  ///< as it is printed: mm, inch, ...
  double mm = 1.0;
};

/// @param told  by the part file, in place of what the file says; "" = nothing
/// @param warnings  gets reasons to doubt
/// @throws std::invalid_argument  told something that is no unit
/// @throws std::runtime_error  $INSUNITS is a unit that no part is drawn in
DrawingUnit unitOf(const DxfHeader& header, const std::string& told,
                   std::vector<std::string>* warnings);

}  // namespace planar_bin_picking
