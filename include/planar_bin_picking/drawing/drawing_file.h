// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// DXF file -> the contours of a flat part.
///
/// Everything that is not an edge of the part (text, dimensions, hatches, annotation layers, centre
/// lines, invisible layers) is left out; what remains is chained into closed loops and classified.
/// Prints may stay open. Lengths leave this file in metres.

#include "planar_bin_picking/drawing/drawing.h"

#include <string>

namespace planar_bin_picking {

/// Reads the contours of one part. What is not an edge of it, and what no layer that is read shows,
/// cannot refuse it, however damaged.
/// @throws std::runtime_error  naming file, entity or layer, and remedy: unreadable, binary or
///         truncated file, nothing drawn, open or branching contour, self-intersection, several
///         outer contours, unknown unit, a sheet that is not drawn 1:1, an outline that the default
///         list of layers would leave out, absurd size (outside 1 mm .. 10 m) or number of entities
/// @throws std::invalid_argument  a parameter out of its range
Drawing loadDrawing(const std::string& path, const DrawingParams& params = {});

}  // namespace planar_bin_picking
