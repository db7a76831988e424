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
  std::vector<int> count(outlines.size(), 0);
  for (const std::size_t i : order) {
    const PoseHypothesis& p = poses[i];
    if (count[p.part] >= (p.inlier_score < score_min ? limits.least : limits.most)) continue;
    const bool duplicate = std::any_of(kept.begin(), kept.end(), [&](std::size_t j) {
      const PoseHypothesis& k = poses[j];
      return k.part == p.part && k.face == p.face &&
             poseDistance(*outlines[p.part].part, k.T_camera_part, p.T_camera_part, p.face) <
                 distance;
    });
    if (duplicate) continue;
    kept.push_back(i);
    ++count[p.part];
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
