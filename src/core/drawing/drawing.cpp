// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/drawing/drawing.h"

namespace planar_bin_picking {

double lengthOf(const Loop& loop) {
  double length = 0.0;
  const std::size_t n = loop.points.size();
  for (std::size_t i = 0; i + (loop.closed ? 0 : 1) < n; ++i) {
    length += (loop.points[(i + 1) % n] - loop.points[i]).norm();
  }
  return length;
}

}  // namespace planar_bin_picking
