// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Plane geometry of closed polygons; the last point joins the first.

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace planar_bin_picking {

using Polygon = std::vector<Eigen::Vector2d>;

/// Positive where the points run counter-clockwise.
double signedArea(const Polygon& polygon);

/// Integral of the position over the area, signed as the area is: centroid = moment / area.
Eigen::Vector2d signedMoment(const Polygon& polygon);

/// Whether the point lies inside; either answer on the border itself.
bool contains(const Polygon& polygon, const Eigen::Vector2d& point);

double distanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b);

/// Where two of the polygons, or one with itself, cross or touch.
struct Crossing {
  std::size_t first = 0, second = 0;  ///< indices of the polygons, first <= second
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
};

/// The first crossing found, if any. Neighbouring sides may meet in their common point only.
/// @param tolerance  sides closer than this touch
/// @throws std::runtime_error  so many sides lie so close together that it would take too long
/// Cost: near O(n log n), wherever the sides lie
std::optional<Crossing> findCrossing(const std::vector<Polygon>& polygons, double tolerance);

}  // namespace planar_bin_picking
