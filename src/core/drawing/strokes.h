// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What draughtsmen leave lying about among the edges: slivers, and lines drawn twice.

#include "drawing/contours.h"

#include <cstddef>

namespace planar_bin_picking {

/// What remains, and how much was taken away.
struct CleanStrokes {
  std::vector<Stroke> strokes;
  std::size_t slivers = 0;  ///< shorter than the tolerance, and no contour runs through
  std::size_t twice = 0;    ///< drawn over others, whole or in part
};

/// Drops strokes without length and slivers, and what is drawn twice, in either direction and also
/// in part: where the end of a stroke lies on another along which it runs, this one is cut there.
CleanStrokes cleanStrokes(const std::vector<Stroke>& strokes, double tolerance);

}  // namespace planar_bin_picking
