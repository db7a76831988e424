// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/wall_evidence.h"

#include "locate/evidence/inlier_score.h"

namespace planar_bin_picking {

std::optional<double> wallScore(const EdgeMap& edges, const Camera& camera,
                                const std::vector<LocalPoint>& points, const Solid& solid,
                                const Eigen::Isometry3d& T_camera_centre) {
  constexpr SearchProfile kAbout{2, true, 0.8};
  constexpr float kWide = 2.0f;     // pixels: a wall so wide has two edges
  constexpr double kReach = 1.7;    // pixels off its place at which an edge no longer counts
  constexpr double kSeen = 0.4;     // of the upper edge
  constexpr std::size_t kFew = 20;  // points say nothing
  std::vector<EdgeHit> hits;
  findHits(edges, camera, points, solid, T_camera_centre, kAbout, &hits);
  std::vector<LocalPoint> at_walls;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (hits[i].wall_px >= kWide && inlierScore(hits[i], kReach) > kSeen)
      at_walls.push_back(points[i]);
  if (at_walls.size() < kFew) return std::nullopt;
  const Eigen::Translation3d lower(0.0, 0.0, solid.far_contour * solid.radius);
  findHits(edges, camera, at_walls, {solid.radius}, T_camera_centre * lower, kAbout, &hits);
  return inlierScore(hits, kReach);
}

}  // namespace planar_bin_picking
