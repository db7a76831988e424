// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The simulated cell's own reading of an ASCII drawing, as lines of points. It shares nothing with
/// the localizer's, and reads no more than its parts need.

#include <Eigen/Core>

#include <string>
#include <vector>

namespace planar_bin_picking::cell {

using Polygon = std::vector<Eigen::Vector2d>;  ///< metres; the last point joins the first

struct DrawnLines {
  std::vector<Polygon> edges;   ///< open; pieces of contours, in no order
  std::vector<Polygon> prints;  ///< open; centre lines, on layers PRINT*, SILK* and ENGRAVE*
};

/// Reads LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and SPLINE, in blocks (INSERT) as well, in
/// millimetres, on all layers but DIM*, CENTER* and TITLE*. Texts, dimensions, hatches and points
/// are passed over.
/// @param chord  how far a chord may lie off its curve, metres
/// @throws std::runtime_error  unreadable, or another kind of entity
DrawnLines readLines(const std::string& path, double chord);

}  // namespace planar_bin_picking::cell
