// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace planar_bin_picking::cell {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kJoin = 2e-5;  // metres; ends this near meet

bool meet(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - b).norm() < kJoin; }

/// Joins lines at their ends to rings.
std::vector<Polygon> joinRings(std::vector<Polygon> lines) {
  std::vector<Polygon> rings;
  while (!lines.empty()) {
    Polygon ring = lines.back();
    lines.pop_back();
    while (!meet(ring.front(), ring.back())) {
      const auto next = std::find_if(lines.begin(), lines.end(), [&](const Polygon& line) {
        return meet(line.front(), ring.back()) || meet(line.back(), ring.back());
      });
      if (next == lines.end()) throw std::runtime_error("has a contour that is not closed");
      if (!meet(next->front(), ring.back())) std::reverse(next->begin(), next->end());
      ring.insert(ring.end(), next->begin() + 1, next->end());
      lines.erase(next);
    }
    ring.pop_back();
    rings.push_back(ring);
  }
  return rings;
}

bool inside(const Polygon& ring, const Eigen::Vector2d& p) {
  bool in = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const auto &a = ring[i], &b = ring[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()))
      in = !in;
  }
  return in;
}

double distanceToSides(const Polygon& ring, const Eigen::Vector2d& p) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i], d = ring[(i + 1) % ring.size()] - a;
    const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-18), 0.0, 1.0);
    best = std::min(best, (a + t * d - p).norm());
  }
  return best;
}

double distanceToOutline(const Shape& shape, const Eigen::Vector2d& p) {
  double best = distanceToSides(shape.outer, p);
  for (const Polygon& hole : shape.holes) best = std::min(best, distanceToSides(hole, p));
  return best;
}

Eigen::Vector2d centroid(const Polygon& ring) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i], b = ring[(i + 1) % ring.size()];
    sum += (a + b) * (a.x() * b.y() - b.x() * a.y());
  }
  return sum / (6.0 * area(ring));
}

/// Some corners of all rings, and their image under a map, against the outline.
bool liesOnItself(const Shape& shape, const Eigen::Matrix2d& turn, const Eigen::Vector2d& center,
                  double tolerance) {
  const auto fits = [&](const Polygon& ring) {
    return std::all_of(ring.begin(), ring.end(), [&](const Eigen::Vector2d& p) {
      return distanceToOutline(shape, center + turn * (p - center)) <= tolerance;
    });
  };
  return fits(shape.outer) && std::all_of(shape.holes.begin(), shape.holes.end(), fits);
}

Eigen::Isometry3d about(const Eigen::Vector2d& center, double z, const Eigen::Matrix3d& R) {
  const Eigen::Vector3d c(center.x(), center.y(), z);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = c - R * c;
  return T;
}

}  // namespace

Shape loadShape(const std::string& path, double thickness, double chord) {
  try {
    DrawnLines lines = readLines(path, chord);
    std::vector<Polygon> rings = joinRings(std::move(lines.edges));
    if (rings.empty()) throw std::runtime_error("has no edge");
    std::sort(rings.begin(), rings.end(), [](const Polygon& a, const Polygon& b) {
      return std::abs(area(a)) > std::abs(area(b));
    });
    for (std::size_t i = 0; i < rings.size(); ++i)
      if ((area(rings[i]) > 0.0) != (i == 0)) std::reverse(rings[i].begin(), rings[i].end());
    return {rings[0], {rings.begin() + 1, rings.end()}, thickness, std::move(lines.prints)};
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

double area(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5 * twice;
}

double area(const Shape& shape) {
  double sum = area(shape.outer);
  for (const Polygon& hole : shape.holes) sum += area(hole);  // clockwise: negative
  return sum;
}

bool contains(const Shape& shape, const Eigen::Vector2d& point) {
  return inside(shape.outer, point) &&
         std::none_of(shape.holes.begin(), shape.holes.end(),
                      [&](const Polygon& hole) { return inside(hole, point); });
}

std::vector<Eigen::Isometry3d> symmetries(const Shape& shape, double tolerance) {
  constexpr int kSteps = 720;  // half degrees, for mirror axes
  constexpr int kMostTurns = 36;
  const Eigen::Vector2d center = centroid(shape.outer);
  std::vector<Eigen::Isometry3d> found = {Eigen::Isometry3d::Identity()};
  const auto rotation = [](double a) { return Eigen::Rotation2Dd(a).toRotationMatrix(); };
  int order = 1;
  for (int k = 2; k <= 2 * kMostTurns; ++k)
    if (liesOnItself(shape, rotation(2.0 * kPi / k), center, tolerance)) order = k;
  for (int i = 1; i < order; ++i) {
    found.push_back(about(
        center, 0.0,
        Eigen::AngleAxisd(2.0 * kPi * i / order, Eigen::Vector3d::UnitZ()).toRotationMatrix()));
  }
  // A turn by half a circle about an axis in the middle plane mirrors the outline.
  for (int i = 0; i < kSteps; ++i) {
    const double axis = kPi * i / kSteps;
    const Eigen::Matrix2d mirror =
        rotation(axis) * Eigen::Vector2d(1.0, -1.0).asDiagonal() * rotation(-axis);
    if (!liesOnItself(shape, mirror, center, tolerance)) continue;
    const Eigen::Vector3d direction(std::cos(axis), std::sin(axis), 0.0);
    const Eigen::Isometry3d flip =
        about(center, -0.5 * shape.thickness, Eigen::AngleAxisd(kPi, direction).toRotationMatrix());
    const std::size_t turns = found.size();
    for (std::size_t k = 0; k < turns; ++k) found.push_back(found[k] * flip);
    break;
  }
  return found;
}

}  // namespace planar_bin_picking::cell
