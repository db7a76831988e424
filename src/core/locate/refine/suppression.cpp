// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/suppression.h"

#include "part/pose_distance.h"
#include "planar_bin_picking/part/face_grid.h"

#include <algorithm>
#include <numeric>

namespace planar_bin_picking {
namespace {

/// Of the inlier score: what an alignment that is still to come, or a search about the pose, may
/// gain.
constexpr double kClearly = 0.12;
constexpr std::size_t kSamples = 32;  // of a face, at most: an overlap to some per cent

std::vector<std::size_t> bestFirst(const std::vector<PoseHypothesis>& poses) {
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return poses[a].inlier_score > poses[b].inlier_score;
  });
  return order;
}

/// A posed part's face in the ideal image plane.
class SeenFace {
 public:
  SeenFace(const PoseHypothesis& pose, const PartModel& part)
      : grid_(&part.faceGrid()),
        face_(grid_->corner(0, 0), grid_->corner(grid_->cols(), grid_->rows())) {
    Eigen::Matrix3d from_face = pose.T_camera_part.linear();
    from_face.col(2) = pose.T_camera_part * Eigen::Vector3d(0.0, 0.0, part.faceZ(pose.face));
    to_face_ = from_face.inverse();
    const auto& cells = grid_->cells();
    const std::size_t stride = 1 + cells.size() / kSamples;
    for (std::size_t k = 0; k < cells.size(); k += stride) {
      samples_.push_back((from_face * cells[k].homogeneous()).hnormalized());
      box_.extend(samples_.back());
    }
  }
  /// Share of the face that lies where the other one is seen.
  double shareOn(const SeenFace& other) const {
    if (!box_.intersects(other.box_)) return 0.0;
    const auto on = std::count_if(samples_.begin(), samples_.end(),
                                  [&](const Eigen::Vector2d& p) { return other.covers(p); });
    return static_cast<double>(on) / static_cast<double>(samples_.size());
  }

 private:
  bool covers(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d on_face = (to_face_ * p.homogeneous()).hnormalized();
    if (!face_.contains(on_face)) return false;
    const int near = grid_->cellNear(on_face);
    return near >= 0 &&
           (grid_->cells()[near] - on_face).cwiseAbs().maxCoeff() <= 0.5 * grid_->cellSize();
  }

  const FaceGrid* grid_;
  Eigen::AlignedBox2d face_;
  Eigen::Matrix3d to_face_;  // x and y on the face of a point of the image plane
  std::vector<Eigen::Vector2d> samples_;
  Eigen::AlignedBox2d box_;  // of these
};

}  // namespace

std::vector<std::size_t> withoutDuplicates(const std::vector<PoseHypothesis>& poses,
                                           const std::vector<PartOutline>& outlines,
                                           double distance, double score_min,
                                           const PoseLimits& limits) {
  std::vector<std::size_t> kept;
  std::vector<std::vector<std::size_t>> kept_of(outlines.size());  // by part
  for (const std::size_t i : bestFirst(poses)) {
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
                                          const std::vector<PartOutline>& outlines,
                                          double overlap_max) {
  std::vector<SeenFace> seen;
  for (const auto& p : poses) seen.emplace_back(p, *outlines[p.part].part);
  std::vector<std::size_t> kept;
  for (const std::size_t i : bestFirst(poses)) {
    bool outscored = false;
    for (std::size_t k = 0; k < kept.size() && !outscored; ++k) {
      const std::size_t j = kept[k];
      if (poses[j].inlier_score <= poses[i].inlier_score + kClearly) break;
      const auto shares = std::minmax({seen[i].shareOn(seen[j]), seen[j].shareOn(seen[i])});
      // A small part may lie on a large one.
      outscored = (poses[i].part == poses[j].part ? shares.second : shares.first) > overlap_max;
    }
    if (!outscored) kept.push_back(i);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace planar_bin_picking
