// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a drawing shows the part in its size, or a sheet on which it is drawn smaller or larger.

#include "drawing/dxf/dxf_file.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

/// By what the dimensions say and what they measure in the drawing.
/// @param mm_per_unit  of the drawing's unit, to tell a sheet's scale from a display in another
/// unit
/// @param warnings     gets what was found and is not certain
/// @return  how many times larger the part is than it is drawn; 1 where nothing says otherwise
/// @throws std::runtime_error  the dimensions contradict what is drawn, without agreeing with the
///         file's own factor
double sheetScale(const DxfFile& file, double mm_per_unit, std::vector<std::string>* warnings);

}  // namespace planar_bin_picking
