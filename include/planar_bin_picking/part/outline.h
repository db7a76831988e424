// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part's contours as the samples that all stages work on.

#include "planar_bin_picking/drawing/drawing.h"

#include <vector>

namespace planar_bin_picking {

/// One point of the outline, in the part frame's x and y.
struct OutlinePoint {
  Eigen::Vector2d position;  ///< metres
  Eigen::Vector2d normal;    ///< unit, out of the material (for a print: to the right of the line)
  int loop = 0;              ///< index into Drawing::loops
  LoopKind kind = LoopKind::kOuter;
};

/// Evenly spaced along all loops, loop by loop, in order; prints at the end.
/// @pre  an outer loop with an extent
std::vector<OutlinePoint> sampleOutline(const Drawing& drawing);

}  // namespace planar_bin_picking
