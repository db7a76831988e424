// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/corner_evidence.h"

#include "base/polygon.h"
#include "base/scatter.h"
#include "locate/evidence/inlier_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_bin_picking {
namespace {

constexpr double kStraight = 0.9986;     // cosine of 3 degrees: drawn arcs turn by more
constexpr double kLeastSide = 0.12;      // radii: shorter ones are teeth and chamfers
constexpr std::size_t kMostSides = 12;   // the longest: time
constexpr double kStep = 0.01;           // radii, between points
constexpr double kReachRadii = 0.6;      // of what is looked at beyond a corner
constexpr double kSidePx = 16.0;         // of a side, up to its corner
constexpr double kFreePx = 5.0;          // off the contour, whose own edges reach so far
constexpr double kBeyondPx = 14.0;       // beyond where the line is free
constexpr double kSpacingPx = 1.5;       // along both
constexpr std::size_t kLeastPoints = 4;  // of either: fewer tell nothing
constexpr double kLeastPx = 1.0;         // of a radius: less is seen edge-on, or nothing at all
/// Inlier score of a line beyond a corner that clutter and texture give, too.
constexpr double kByChance = 0.3;
/// Share of the side's own height from which on an edge beyond it is as clear as the side.
constexpr double kAsClear = 0.7;

/// Points of the loop's polygon that one straight side runs from and to.
struct Side {
  Eigen::Vector2d from, to;
  double length() const { return (to - from).norm(); }
};

std::vector<Side> straightSides(const Polygon& outer) {
  const std::size_t n = outer.size();
  const auto direction = [&](std::size_t i) {
    return Eigen::Vector2d((outer[(i + 1) % n] - outer[i % n]).normalized());
  };
  std::size_t start = 0;  // a corner
  while (start < n && direction(start).dot(direction(start + n - 1)) > kStraight) ++start;
  std::vector<Side> sides;
  for (std::size_t i = start; i < start + n;) {
    std::size_t end = i + 1;
    while (end < start + n && direction(end).dot(direction(i)) > kStraight) ++end;
    sides.push_back({outer[i % n], outer[end % n]});
    i = end;
  }
  return sides;
}

double distanceTo(const Polygon& outer, const Eigen::Vector2d& point) {
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < outer.size(); ++i)
    least = std::min(least, distanceToSegment(point, outer[i], outer[(i + 1) % outer.size()]));
  return least;
}

/// The side's end at `to`; its outward normal stays that of the direction in which the loop runs.
SideEnd endOf(const PartModel& part, const Polygon& outer, const Side& side, bool at_end) {
  const double r = part.radius();
  const Eigen::Vector2d along = (side.to - side.from).normalized();
  const Eigen::Vector2d corner = at_end ? side.to : side.from;
  const Eigen::Vector2d out = at_end ? along : Eigen::Vector2d(-along);
  const auto local = [&](const Eigen::Vector2d& at) {
    const Eigen::Vector2d p = (at - part.center()) / r;
    return LocalPoint{p.x(), p.y(), along.x(), along.y(), 0};
  };
  SideEnd end;
  for (double d = 0.5 * kStep; d < std::min(kReachRadii, side.length() / r); d += kStep)
    end.side.push_back(local(corner - d * r * out));
  for (double d = kStep; d < kReachRadii; d += kStep) {
    const Eigen::Vector2d at = corner + d * r * out;
    if (contains(outer, at)) break;
    end.beyond.push_back(local(at));
    end.from_contour.push_back(distanceTo(outer, at) / r);
  }
  return end;
}

/// Indices of every few of so many points of a line, from `first` on and over so many pixels.
std::vector<std::size_t> pieceOf(std::size_t points, std::size_t first, double length_px,
                                 double px_per_radius) {
  const double step_px = kStep * px_per_radius;
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::floor(kSpacingPx / step_px)));
  const auto end = std::min(points, first + static_cast<std::size_t>(length_px / step_px) + 1);
  std::vector<std::size_t> out;
  for (std::size_t k = first; k < end; k += stride) out.push_back(k);
  return out;
}

std::vector<LocalPoint> lastOf(const SideEnd& end, double px_per_radius) {
  std::vector<LocalPoint> out;
  for (const std::size_t k : pieceOf(end.side.size(), 0, kSidePx, px_per_radius))
    out.push_back(end.side[k]);
  return out;
}

/// Where it is free of the contour's own edges.
std::vector<LocalPoint> freeOf(const SideEnd& end, double px_per_radius) {
  const auto isFree = [&](double from_contour) { return from_contour * px_per_radius >= kFreePx; };
  const auto& from = end.from_contour;
  const auto first = std::find_if(from.begin(), from.end(), isFree) - from.begin();
  std::vector<LocalPoint> out;
  for (const std::size_t k :
       pieceOf(from.size(), static_cast<std::size_t>(first), kBeyondPx, px_per_radius))
    if (isFree(from[k])) out.push_back(end.beyond[k]);
  return out;
}

}  // namespace

std::vector<SideEnd> sideEndsOf(const PartModel& part) {
  const auto& loops = part.file().drawing.loops;
  const auto outer = std::find_if(loops.begin(), loops.end(),
                                  [](const Loop& l) { return l.kind == LoopKind::kOuter; });
  std::vector<Side> sides;
  for (const Side& side : straightSides(outer->points))
    if (side.length() > kLeastSide * part.radius()) sides.push_back(side);
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.length() > b.length(); });
  if (sides.size() > kMostSides) sides.resize(kMostSides);
  std::vector<SideEnd> ends;
  for (const Side& side : sides)
    for (const bool at_end : {false, true})
      ends.push_back(endOf(part, outer->points, side, at_end));
  return ends;
}

std::optional<double> edgesBeyondCorners(const EdgeMap& edges, const Camera& camera,
                                         const std::vector<SideEnd>& ends, const PosedPart& posed,
                                         double reach_px) {
  if (posed.px_per_radius < kLeastPx) return std::nullopt;
  double sum = 0.0, weights = 0.0;
  std::vector<EdgeHit> hits, hits_beyond;
  for (const SideEnd& end : ends) {
    auto side = lastOf(end, posed.px_per_radius), beyond = freeOf(end, posed.px_per_radius);
    if (std::min(side.size(), beyond.size()) < kLeastPoints) continue;
    moveInward(posed.edge_offset, &side);
    moveInward(posed.edge_offset, &beyond);
    findHits(edges, camera, side, posed.solid, posed.T_camera_centre, kInlierProfile, &hits);
    findHits(edges, camera, beyond, posed.solid, posed.T_camera_centre, kInlierProfile,
             &hits_beyond);
    std::vector<double> heights;
    for (const EdgeHit& hit : hits)
      if (hit.found) heights.push_back(hit.height);
    if (heights.empty()) continue;
    const double clear = kAsClear * median(std::move(heights));
    double goes_on = 0.0;
    for (const EdgeHit& hit : hits_beyond)
      goes_on += inlierScore(hit, reach_px) * std::min(1.0, hit.height / clear);
    goes_on /= static_cast<double>(hits_beyond.size());
    const double weight = inlierScore(hits, reach_px);
    sum += weight * std::max(0.0, goes_on - kByChance) / (1.0 - kByChance);
    weights += weight;
  }
  if (weights <= 0.0) return std::nullopt;
  return sum / weights;
}

}  // namespace planar_bin_picking
