// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The simulated cell's own view of a part: rings read from the raw drawing. Nothing here is shared
/// with the localizer, so that a mistake in one cannot hide in the other.

#include "sim/drawing_lines.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace planar_bin_picking::cell {

struct Shape {
  Polygon outer;                  ///< counter-clockwise
  std::vector<Polygon> holes;     ///< clockwise
  double thickness = 0.0;         ///< metres; the body lies in -thickness <= z <= 0
  std::vector<Polygon> prints{};  ///< centre lines of strokes on the front face, open
};

/// Joins what readLines finds to rings. The one with the largest area is the outer one.
/// @param chord  how far a chord may lie off its arc, metres
/// @throws std::runtime_error  as readLines, or an open contour: file and what
Shape loadShape(const std::string& path, double thickness, double chord);

double area(const Polygon& polygon);  ///< of a ring, counter-clockwise positive
double area(const Shape& shape);      ///< without its holes

/// T_part_same of all turns, also upside down, after which the shape lies on itself, whatever is
/// printed on it; identity first. A disc's turns are given in steps of five degrees.
/// @param tolerance  metres
std::vector<Eigen::Isometry3d> symmetries(const Shape& shape, double tolerance);

/// Whether a point of the plane lies in the material.
bool contains(const Shape& shape, const Eigen::Vector2d& point);

}  // namespace planar_bin_picking::cell
