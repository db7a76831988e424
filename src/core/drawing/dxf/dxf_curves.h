// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The curves of a DXF drawing in one form, and how they become chords.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <functional>
#include <vector>

namespace planar_bin_picking {

/// A curve in the plane, smooth between neighbouring breaks.
struct Curve {
  std::vector<double> breaks;  ///< ascending parameters, two or more; empty = no curve
  std::function<Eigen::Vector2d(double)> at;
  bool closed = false;                   ///< drawn as closed: it ends where it begins
  std::vector<Eigen::Vector2d> centers;  ///< of its arcs
};

/// A point of a polyline; `bulge` is the tangent of a quarter of the angle of the arc to the next
/// point, positive counter-clockwise, 0 for a straight line.
struct BulgeVertex {
  Eigen::Vector2d position;
  double bulge = 0.0;
};

struct SplineData {
  int degree = 3;
  bool closed = false;
  std::vector<double> knots, weights;
  std::vector<Eigen::Vector2d> control_points, fit_points;
  Eigen::Vector2d start_tangent = Eigen::Vector2d::Zero();  ///< of fit points; zero where unknown
  Eigen::Vector2d end_tangent = Eigen::Vector2d::Zero();
};

Curve makeLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to);

/// center + major cos(t) + minor sin(t) for t from `start` to `end`, counter-clockwise in that
/// sense; angles that are equal but for full turns make the full ellipse, equal angles no curve.
Curve makeEllipse(const Eigen::Vector2d& center, const Eigen::Vector2d& major,
                  const Eigen::Vector2d& minor, double start, double end);

Curve makePolyline(std::vector<BulgeVertex> vertices, bool closed);

/// Control points are evaluated by de Boor's algorithm; fit points alone are interpolated by a
/// cubic spline over chord length, as CAD programs do: periodic if closed, else with the given
/// tangents at its ends or, where these are unknown, none of curvature.
/// @throws std::runtime_error  naming what does not fit together
Curve makeSpline(const SplineData& spline);

/// The curve, placed, as a polyline that stays within `tolerance` of it.
/// @param points_max  more than these are refused before they are computed
/// @throws std::runtime_error  too many points; a point that is no place on earth
std::vector<Eigen::Vector2d> flatten(const Curve& curve, const Eigen::Affine2d& placement,
                                     double tolerance, std::size_t points_max);

}  // namespace planar_bin_picking
