// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/polygon.h"

#include "base/box_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar_bin_picking {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// One side of a polygon.
struct Side {
  std::size_t polygon = 0, index = 0;
  Eigen::Vector2d a, b;
};

bool bothSides(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p,
               const Eigen::Vector2d& q) {
  return cross(b - a, p - a) * cross(b - a, q - a) < 0.0;
}

/// A point that both segments share, within the tolerance.
std::optional<Eigen::Vector2d> sharedPoint(const Side& s, const Side& t, double tolerance) {
  if (bothSides(s.a, s.b, t.a, t.b) && bothSides(t.a, t.b, s.a, s.b)) {
    const double along = cross(t.a - s.a, t.b - t.a) / cross(s.b - s.a, t.b - t.a);
    return s.a + along * (s.b - s.a);
  }
  if (distanceToSegment(s.a, t.a, t.b) <= tolerance) return s.a;
  if (distanceToSegment(s.b, t.a, t.b) <= tolerance) return s.b;
  if (distanceToSegment(t.a, s.a, s.b) <= tolerance) return t.a;
  if (distanceToSegment(t.b, s.a, s.b) <= tolerance) return t.b;
  return std::nullopt;
}

/// Where the side after a corner runs back over the side before it.
std::optional<Eigen::Vector2d> foldPoint(const Side& before, const Side& after, double tolerance) {
  const Eigen::Vector2d back = before.a - before.b, on = after.b - after.a;
  if (back.dot(on) <= 0.0) return std::nullopt;
  const double shorter = std::min(back.norm(), on.norm());
  const double apart = std::abs(cross(back.normalized(), on.normalized())) * shorter;
  if (apart > tolerance || shorter <= tolerance) return std::nullopt;
  return before.b;
}

std::optional<Eigen::Vector2d> meet(Side s, Side t, const std::vector<Polygon>& polygons,
                                    double tolerance) {
  if (s.polygon == t.polygon) {
    if (s.index > t.index) std::swap(s, t);
    const std::size_t count = polygons[s.polygon].size();
    if (t.index == s.index + 1) return foldPoint(s, t, tolerance);
    if (s.index == 0 && t.index == count - 1) return foldPoint(t, s, tolerance);
  }
  return sharedPoint(s, t, tolerance);
}

std::vector<Side> sidesOf(const std::vector<Polygon>& polygons) {
  std::vector<Side> sides;
  for (std::size_t k = 0; k < polygons.size(); ++k) {
    for (std::size_t i = 0; i < polygons[k].size(); ++i) {
      sides.push_back({k, i, polygons[k][i], polygons[k][(i + 1) % polygons[k].size()]});
    }
  }
  return sides;
}

}  // namespace

double signedArea(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    twice += cross(polygon[i] - polygon[0], polygon[(i + 1) % polygon.size()] - polygon[0]);
  }
  return 0.5 * twice;
}

Eigen::Vector2d signedMoment(const Polygon& polygon) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i] - polygon[0];
    const Eigen::Vector2d b = polygon[(i + 1) % polygon.size()] - polygon[0];
    sum += cross(a, b) / 6.0 * (a + b);
  }
  return sum + signedArea(polygon) * polygon[0];
}

bool contains(const Polygon& polygon, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

double distanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double along = length2 > 0.0 ? std::clamp((point - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (a + along * ab - point).norm();
}

std::optional<Crossing> findCrossing(const std::vector<Polygon>& polygons, double tolerance) {
  const std::vector<Side> sides = sidesOf(polygons);
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const Side& s : sides) {
    boxes.emplace_back(s.a.cwiseMin(s.b), s.a.cwiseMax(s.b));
  }
  const BoxTree tree(boxes);
  std::optional<Crossing> found;
  for (std::size_t i = 0; i < sides.size() && !found; ++i) {
    const Side& s = sides[i];
    const Eigen::AlignedBox2d around(boxes[i].min().array() - tolerance,
                                     boxes[i].max().array() + tolerance);
    tree.any(around, [&](std::size_t j) {
      if (j <= i) return false;
      const Side& t = sides[j];
      if (const auto point = meet(s, t, polygons, tolerance))
        found = Crossing{std::min(s.polygon, t.polygon), std::max(s.polygon, t.polygon), *point};
      return found.has_value();
    });
  }
  return found;
}

}  // namespace planar_bin_picking
