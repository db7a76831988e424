// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a draughtsman's line type says about a line.

#include "drawing/dxf/dxf_file.h"

#include <string>

namespace planar_bin_picking {

enum class LineMeaning : std::uint8_t {
  kEdge,
  kUnknown,     ///< neither the name nor the file's table tells; it is read as an edge
  kAnnotation,  ///< axes, hidden edges, construction
  kNeighbour    ///< dash and two dots: what stands around the part, such as its raw sheet
};

/// By the pattern in the file's table, where there is one with gaps; else by the name, in the
/// languages of the usual CAD programs.
/// @param linetype  neither BYLAYER nor BYBLOCK
LineMeaning meaningOf(const std::string& linetype, const DxfFile& file);

}  // namespace planar_bin_picking
