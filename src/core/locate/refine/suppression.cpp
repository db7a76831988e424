// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/suppression.h"

#include "part/pose_distance.h"

#include <algorithm>
#include <numeric>

namespace planar_bin_picking {
namespace {

/// Share of the part's grain: centres nearer than this cannot be of two parts, whatever covers
/// them.
constexpr double kSamePlace = 0.35;
/// Of the inlier score: what an alignment that is still to come, or a search about the pose, may
/// gain.
constexpr double kClearly = 0.12;

}  // namespace

std::vector<std::size_t> withoutDuplicates(const std::vector<PoseHypothesis>& poses,
                                           const std::vector<PartOutline>& outlines,
                                           double distance, double score_min,
                                           const PoseLimits& limits) {
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return poses[a].inlier_score > poses[b].inlier_score;
  });
  std::vector<std::size_t> kept;
  std::vector<std::vector<std::size_t>> kept_of(outlines.size());  // by part
  for (const std::size_t i : order) {
    const PoseHypothesis& p = poses[i];
    auto& others = kept_of[p.part];
    const int most = p.inlier_score < score_min ? limits.least : limits.most;
    if (static_cast<int>(others.size()) >= most) continue;
    const bool duplicate = std::any_of(others.begin(), others.end(), [&](std::size_t j) {
      const PoseHypothesis& k = poses[j];
      return k.face == p.face && poseDistance(*outlines[p.part].part, k.T_camera_part,
                                              p.T_camera_part, p.face) < distance;
    });
    if (duplicate) continue;
    kept.push_back(i);
    others.push_back(i);
  }
  return kept;
}

std::vector<std::size_t> withoutOutscored(const std::vector<PoseHypothesis>& poses,
                                          const std::vector<PartOutline>& outlines) {
  std::vector<Eigen::Vector2d> seen;
  std::vector<double> reach;
  for (const auto& p : poses) {
    const PartOutline& outline = outlines[p.part];
    const Eigen::Vector3d c = p.T_camera_part * centreOf(*outline.part, p.face).translation();
    seen.push_back(c.hnormalized());
    reach.push_back(kSamePlace * outline.grain / c.z());
  }
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    bool outscored = false;
    for (std::size_t j = 0; j < poses.size() && !outscored; ++j) {
      outscored = poses[j].part == poses[i].part &&
                  poses[j].inlier_score > poses[i].inlier_score + kClearly &&
                  (seen[j] - seen[i]).norm() < reach[i];
    }
    if (!outscored) kept.push_back(i);
  }
  return kept;
}

}  // namespace planar_bin_picking
