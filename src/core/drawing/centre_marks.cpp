// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/centre_marks.h"

#include "base/box_tree.h"
#include "base/polygon.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace planar_bin_picking {
namespace {

constexpr double kNoArea = 1e-9;  // square millimetres: against a division by zero

using Points = std::vector<Eigen::Vector2d>;

Eigen::AlignedBox2d boxOf(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {a.cwiseMin(b), a.cwiseMax(b)};
}

/// A straight line that meets nothing.
struct LooseLine {
  std::size_t stroke = 0;
  Eigen::Vector2d a, b;
};

/// Where the centers are that it may belong to: no farther away than it is long.
Eigen::AlignedBox2d reachOf(const LooseLine& line) {
  const double length = (line.b - line.a).norm();
  const Eigen::Vector2d margin(length, length);
  return {line.a.cwiseMin(line.b) - margin, line.a.cwiseMax(line.b) + margin};
}

std::vector<LooseLine> looseLines(const std::vector<Stroke>& strokes, double tolerance) {
  const Joints joints(strokes, tolerance);
  std::vector<LooseLine> loose;
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    const Points& points = strokes[i].points;
    const bool straight = points.size() == 2;
    if (straight && joints.isLoose(2 * i) && joints.isLoose(2 * i + 1))
      loose.push_back({i, points.front(), points.back()});
  }
  return loose;
}

/// The middle of a closed stroke: the centroid of its area.
Eigen::Vector2d middleOf(const Points& points) {
  const double area = signedArea(points);
  if (std::abs(area) < kNoArea) return points.front();
  // Relative to one of its points, for the digits.
  Points local = points;
  for (Eigen::Vector2d& p : local) p -= points.front();
  return points.front() + signedMoment(local) / area;
}

std::vector<Eigen::Vector2d> centersOf(const std::vector<Stroke>& strokes) {
  std::vector<Eigen::Vector2d> centers;
  for (const Stroke& stroke : strokes) {
    centers.insert(centers.end(), stroke.centers.begin(), stroke.centers.end());
    if (stroke.closed) centers.push_back(middleOf(stroke.points));
  }
  return centers;
}

/// The loose lines that point at the center in a direction, and whether they reach equally far on
/// both sides.
struct Arm {
  std::vector<std::size_t> lines;
  double least = 0.0, most = 0.0;
  bool isBalanced(double tolerance) const {
    return most > tolerance && least < -tolerance && std::abs(most + least) <= tolerance;
  }
};

Arm armAlong(const Eigen::Vector2d& direction, const Eigen::Vector2d& center,
             const std::vector<LooseLine>& loose, const std::vector<std::size_t>& candidates,
             double tolerance) {
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  Arm arm;
  for (const std::size_t k : candidates) {
    const Eigen::Vector2d a = loose[k].a - center, b = loose[k].b - center;
    if (std::max(std::abs(a.dot(normal)), std::abs(b.dot(normal))) > tolerance) continue;
    arm.lines.push_back(k);
    arm.least = std::min({arm.least, a.dot(direction), b.dot(direction)});
    arm.most = std::max({arm.most, a.dot(direction), b.dot(direction)});
  }
  return arm;
}

}  // namespace

std::size_t dropCentreMarks(std::vector<Stroke>* strokes, double tolerance) {
  const std::vector<LooseLine> loose = looseLines(*strokes, tolerance);
  if (loose.size() < 2) return 0;
  // A mark's line passes its center, or points at it from no farther away than it is long: lines of
  // the next hole in a row do neither.
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const LooseLine& line : loose) boxes.push_back(reachOf(line));
  const BoxTree tree(boxes);
  std::vector<bool> mark(loose.size(), false);
  for (const Eigen::Vector2d& center : centersOf(*strokes)) {
    std::vector<std::size_t> candidates;
    tree.any(boxOf(center, center), [&](std::size_t k) {
      const LooseLine& line = loose[k];
      const Eigen::Vector2d along = (line.b - line.a).normalized(), from = center - line.a;
      const bool points_at_it = std::abs(along.x() * from.y() - along.y() * from.x()) <= tolerance;
      const double gap = distanceToSegment(center, line.a, line.b);
      if (points_at_it && gap <= (line.b - line.a).norm()) candidates.push_back(k);
      return false;
    });
    for (const std::size_t k : candidates) {
      if (mark[k]) continue;
      const Eigen::Vector2d along = (loose[k].b - loose[k].a).normalized();
      const Arm arm = armAlong(along, center, loose, candidates, tolerance);
      const Arm across = armAlong({-along.y(), along.x()}, center, loose, candidates, tolerance);
      if (!arm.isBalanced(tolerance) || !across.isBalanced(tolerance)) continue;
      for (const std::size_t line : arm.lines) mark[line] = true;
      for (const std::size_t line : across.lines) mark[line] = true;
    }
  }
  std::vector<bool> gone(strokes->size(), false);
  for (std::size_t k = 0; k < loose.size(); ++k) gone[loose[k].stroke] = mark[k];
  std::vector<Stroke> kept;
  for (std::size_t i = 0; i < strokes->size(); ++i) {
    if (!gone[i]) kept.push_back(std::move((*strokes)[i]));
  }
  const std::size_t dropped = strokes->size() - kept.size();
  *strokes = std::move(kept);
  return dropped;
}

std::vector<std::pair<std::string, std::size_t>> dropLooseAnnotation(std::vector<Stroke>* strokes,
                                                                     double tolerance) {
  std::map<std::string, std::size_t> dropped;
  for (bool more = true; more;) {
    more = false;
    const Joints joints(*strokes, tolerance);
    std::vector<Stroke> kept;
    for (std::size_t i = 0; i < strokes->size(); ++i) {
      Stroke& stroke = (*strokes)[i];
      if (!stroke.annotation.empty() && (joints.isLoose(2 * i) || joints.isLoose(2 * i + 1))) {
        ++dropped[stroke.annotation];
        more = true;
      } else {
        kept.push_back(std::move(stroke));
      }
    }
    *strokes = std::move(kept);
  }
  return {dropped.begin(), dropped.end()};
}

}  // namespace planar_bin_picking
