// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/wall_evidence.h"

#include "locate/evidence/inlier_score.h"

namespace planar_bin_picking {
namespace {

/// Pixels: the reach ends before the other edge of a wall that is kWide; and a sharp edge.
constexpr SearchProfile kAbout{2, true, 0.8};
constexpr float kWide = 2.0f;     // pixels: a wall so wide has two edges
constexpr double kReachPx = 1.7;  // off its place at which an edge no longer counts: within kWide
constexpr double kSeen = 0.4;     // inlier score of the upper edge: texture mostly has less
constexpr std::size_t kFew = 20;  // points: with fewer, one foreign edge would decide

}  // namespace

std::optional<double> wallScore(const EdgeMap& edges, const Camera& camera,
                                const std::vector<LocalPoint>& points, const Solid& solid,
                                const Eigen::Isometry3d& T_camera_centre) {
  std::vector<EdgeHit> hits;
  findHits(edges, camera, points, solid, T_camera_centre, kAbout, &hits);
  std::vector<LocalPoint> at_walls;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (hits[i].wall_px >= kWide && inlierScore(hits[i], kReachPx) > kSeen)
      at_walls.push_back(points[i]);
  if (at_walls.size() < kFew) return std::nullopt;
  const Eigen::Translation3d lower(0.0, 0.0, solid.far_contour * solid.radius);
  findHits(edges, camera, at_walls, {solid.radius}, T_camera_centre * lower, kAbout, &hits);
  return inlierScore(hits, kReachPx);
}

}  // namespace planar_bin_picking
