// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The text of a DXF file -> what stands in it.

#include "drawing/dxf/dxf_file.h"

#include <string_view>

namespace planar_bin_picking {

/// @throws std::runtime_error  no whole DXF file; too many entities. Names the line, not the file.
DxfFile readDxf(std::string_view content);

}  // namespace planar_bin_picking
