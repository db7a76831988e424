// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/refine.h"

#include "parallel.h"
#include "pose_distance.h"
#include "refine_field.h"
#include "refine_image.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace planar_bin_picking {
namespace {

struct Tracked {
  std::size_t part;
  Face face;
  Eigen::Isometry3d T_camera_centre;
  double support;
};

/// Best first; of poses that agree within `distance` radii only the best stays.
std::vector<Tracked> withoutTwins(std::vector<Tracked> poses, double distance, std::size_t most,
                                  const std::vector<std::shared_ptr<const PartModel>>& parts) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Tracked& a, const Tracked& b) { return a.support > b.support; });
  std::vector<Tracked> kept;
  std::vector<Eigen::Isometry3d> kept_part;
  for (const auto& p : poses) {
    if (kept.size() >= most) break;
    const auto& part = *parts[p.part];
    const Eigen::Isometry3d T = p.T_camera_centre * centreOf(part, p.face).inverse();
    bool twin = false;
    for (std::size_t i = 0; i < kept.size() && !twin; ++i) {
      twin = kept[i].part == p.part && kept[i].face == p.face &&
             poseDistance(part, kept_part[i], T, p.face) < distance;
    }
    if (twin) continue;
    kept.push_back(p);
    kept_part.push_back(T);
  }
  return kept;
}

bool isShape(const OutlinePoint& p) { return p.kind != LoopKind::kPrint; }

}  // namespace

std::vector<RefinedPose> refineCandidates(
    const EdgeMap& edges, const Camera& camera,
    const std::vector<std::shared_ptr<const PartModel>>& parts,
    const std::vector<Candidate>& candidates, const RefineParams& params, int threads) {
  std::vector<std::vector<LocalPoint>> coarse, fine;
  for (const auto& part : parts) {
    coarse.push_back(localPoints(*part, params.field_points, isShape));
    fine.push_back(localPoints(*part, params.image_points, isShape));
  }
  std::vector<Tracked> poses(candidates.size());
  parallelFor(static_cast<int>(candidates.size()), threads, [&](int i) {
    const auto& c = candidates[i];
    const auto& part = *parts[c.part];
    const auto settled = settleInField(edges.field, coarse[c.part], part.radius(),
                                       c.T_camera_part * centreOf(part, c.face),
                                       params.field_reach_px, params);
    poses[i] = {c.part, c.face, settled.T_camera_centre, settled.support};
  });
  poses.erase(std::remove_if(poses.begin(), poses.end(),
                             [&](const Tracked& p) { return p.support < params.field_support_min; }),
              poses.end());
  poses = withoutTwins(std::move(poses), 0.04, params.max_poses, parts);

  std::vector<RefinedPose> out(poses.size());
  const double limit = params.tilt_limit_deg * M_PI / 180.0;
  parallelFor(static_cast<int>(poses.size()), threads, [&](int i) {
    const auto& p = poses[i];
    const auto& part = *parts[p.part];
    ImagePose at;
    at.T_camera_centre = p.T_camera_centre;
    for (const double tukey : {8.0, 6.0, 4.0}) {
      at = stepInImage(edges, camera, fine[p.part], part.radius(), at.T_camera_centre,
                       {8, 1, 1.2}, tukey, limit);
    }
    for (const double tukey : {3.0, 2.0, 2.0}) {
      at = stepInImage(edges, camera, fine[p.part], part.radius(), at.T_camera_centre,
                       {4, 3, 1.0}, tukey, limit);
    }
    RefinedPose& r = out[i];
    r.part = p.part;
    r.face = p.face;
    r.T_camera_part = at.T_camera_centre * centreOf(part, p.face).inverse();
    r.residual_px = at.residual_px;
    Matrix6d H = at.information / std::max(1e-4, at.residual_px * at.residual_px);
    H.diagonal().array() += 1e-6;
    Matrix6d cov = H.ldlt().solve(Matrix6d::Identity());
    Vector6d unit;
    unit << part.radius(), part.radius(), part.radius(), 1.0, 1.0, 1.0;
    r.covariance = unit.asDiagonal() * cov * unit.asDiagonal();
  });
  return out;
}

}  // namespace planar_bin_picking
