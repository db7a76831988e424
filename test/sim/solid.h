// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A flat part as a body: triangles to look at, convex pieces to collide with.

#include "sim/shape.h"

#include <array>
#include <vector>

namespace planar_bin_picking::cell {

struct Mesh {
  std::vector<Eigen::Vector3f> points;         ///< metres, part frame
  std::vector<std::array<unsigned, 3>> faces;  ///< counter-clockwise from outside
};

/// @param bevel  width of the chamfer at all edges, metres: real cut edges have some
Mesh makeMesh(const Shape& shape, double bevel);

/// Convex polygons that together cover the shape. Neighbours are joined as long as their hull is
/// not larger than both by more than `slack` square metres.
std::vector<Polygon> convexPieces(const Shape& shape, double slack);

}  // namespace planar_bin_picking::cell
