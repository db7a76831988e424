// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// DXF file -> the strokes that are edges or prints of the part, placed, in mm; and an account of
/// what is not.

#include "drawing/contours.h"
#include "drawing/dxf/dxf_file.h"
#include "drawing/dxf/line_types.h"
#include "planar_bin_picking/drawing/drawing.h"

#include <map>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// A stroke that looks like an edge, but its layer or line type says that it is none.
struct PassedOver {
  Stroke stroke;
  bool by_line_type = false;  ///< else by a layer of the default list
  std::string name;           ///< of the line type or the layer
  LineMeaning meaning = LineMeaning::kEdge;
};

struct EdgeSelection {
  std::vector<Stroke> edges, prints;
  std::vector<PassedOver> passed_over;
  std::map<std::string, std::size_t> left_out;  ///< how many entities, by reason
  std::vector<std::string> notes;               ///< left out for a reason that needs no number
  std::map<std::string, std::size_t> unknown_linetypes;
};

/// @param mm_per_unit  of the file's numbers, its sheet's scale included
/// @throws std::runtime_error  what would be an edge cannot be read; too many entities or points
EdgeSelection selectEdges(const DxfFile& file, const DrawingParams& params, double mm_per_unit);

/// `layer DIM: 14 entities`
std::string countText(const std::string& what, std::size_t count);

}  // namespace planar_bin_picking
