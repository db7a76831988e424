// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/refine.h"

#include "evidence.h"
#include "parallel.h"
#include "pose_distance.h"
#include "refine_field.h"
#include "refine_image.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr ImageReach kWide{8, 1, 1.2}, kNarrow{4, 3, 1.0};

/// A pose on its way through the levels, with its support at the last one.
struct Tracked {
  std::size_t part;
  Face face;
  Eigen::Isometry3d T_camera_part;
  double support;
  ImagePose image;
};

/// What the levels need of a part, made once per call.
struct Outline {
  const PartModel* part;
  std::vector<LocalPoint> coarse, fine, print;
};

class Refiner {
 public:
  Refiner(const EdgeMap& edges, const Camera& camera, const RefineParams& params,
          const std::vector<std::shared_ptr<const PartModel>>& parts, int threads)
      : edges_(edges), camera_(camera), params_(params), threads_(threads) {
    const auto is_shape = [](const OutlinePoint& p) { return p.kind != LoopKind::kPrint; };
    const auto is_print = [](const OutlinePoint& p) { return p.kind == LoopKind::kPrint; };
    for (const auto& part : parts) {
      outlines_.push_back({part.get(), localPoints(*part, params.field_points, is_shape),
                           localPoints(*part, params.image_points, is_shape),
                           localPoints(*part, params.image_points, is_print)});
    }
  }

  std::vector<Tracked> settle(const std::vector<Candidate>& candidates) const {
    std::vector<Tracked> poses(candidates.size());
    parallelFor(static_cast<int>(candidates.size()), threads_, [&](int i) {
      const auto& c = candidates[i];
      const auto& outline = outlines_[c.part];
      const Eigen::Isometry3d T_part_centre = centreOf(*outline.part, c.face);
      const auto settled =
          settleInField(edges_.field, outline.coarse, outline.part->radius(),
                        c.T_camera_part * T_part_centre, params_.field_reach_px, params_);
      poses[i] = {c.part, c.face, settled.T_camera_centre * T_part_centre.inverse(),
                  settled.support, {}};
    });
    return poses;
  }

  /// Steps in the raw image, the reach shrinking.
  template <std::size_t N>
  void align(const ImageReach& reach, const std::array<double, N>& tukey_px, Tracked* pose) const {
    const auto& outline = outlines_[pose->part];
    const Eigen::Isometry3d T_part_centre = centreOf(*outline.part, pose->face);
    pose->image.T_camera_centre = pose->T_camera_part * T_part_centre;
    for (const double tukey : tukey_px) {
      pose->image = stepInImage(edges_, camera_, outline.fine, outline.part->radius(),
                                pose->image.T_camera_centre, reach, tukey, 0.0);
    }
    pose->T_camera_part = pose->image.T_camera_centre * T_part_centre.inverse();
    pose->support = supportAt(*pose, outline.fine);
  }

  template <std::size_t N>
  void alignAll(const ImageReach& reach, const std::array<double, N>& tukey_px,
                std::vector<Tracked>* poses) const {
    parallelFor(static_cast<int>(poses->size()), threads_,
                [&](int i) { align(reach, tukey_px, &(*poses)[i]); });
  }

  /// Each pose gives way to its best lookalike.
  void resolveAll(std::vector<Tracked>* poses) const {
    parallelFor(static_cast<int>(poses->size()), threads_, [&](int i) {
      resolveShape(&(*poses)[i]);
      resolvePrint(&(*poses)[i]);
    });
  }

  std::vector<Tracked> withoutTwins(std::vector<Tracked> poses, double distance, double support_min,
                                    std::size_t most) const;
  RefinedPose finish(const Tracked& pose) const;

 private:
  double supportAt(const Tracked& pose, const std::vector<LocalPoint>& points) const {
    std::vector<EdgeHit> hits;
    const auto& part = *outlines_[pose.part].part;
    findHits(edges_, camera_, points, part.radius(), pose.T_camera_part * centreOf(part, pose.face),
             kNarrow, &hits);
    return meanSupport(hits, kNarrow.reach_px);
  }

  static Tracked twinOf(const Tracked& pose, const Lookalike& other) {
    Tracked twin = pose;
    twin.T_camera_part = pose.T_camera_part * other.T_part_lookalike;
    if (other.flips) twin.face = pose.face == Face::kFront ? Face::kBack : Face::kFront;
    return twin;
  }

  void resolveShape(Tracked* pose) const {
    constexpr double kHopeless = 0.15;  // support that an alignment does not make up for
    const auto& outline = outlines_[pose->part];
    Tracked best = *pose;
    for (const auto& other : outline.part->lookalikes()) {
      if (other.exact) continue;
      Tracked twin = twinOf(*pose, other);
      if (supportAt(twin, outline.fine) < pose->support - kHopeless) continue;
      align(kNarrow, std::array<double, 2>{4.0, 2.0}, &twin);
      if (twin.support > best.support) best = twin;
    }
    *pose = best;
  }

  /// Of a printed part the front is up where at least half of the print is borne out.
  void resolvePrint(Tracked* pose) const {
    const auto& outline = outlines_[pose->part];
    if (outline.print.empty()) return;
    Tracked front = *pose, back = *pose;
    double print = -1.0;
    const auto consider = [&](const Tracked& twin) {
      if (twin.face == Face::kBack) {
        back = twin;
        return;
      }
      const double support = supportAt(twin, outline.print);
      if (support > print) {
        print = support;
        front = twin;
      }
    };
    consider(*pose);
    for (const auto& other : outline.part->lookalikes()) {
      if (other.exact) consider(twinOf(*pose, other));
    }
    *pose = print > 0.5 ? front : back;
  }

  const EdgeMap& edges_;
  const Camera& camera_;
  const RefineParams& params_;
  int threads_;
  std::vector<Outline> outlines_;
};

/// Best first; of poses that agree within `distance` radii only the best stays.
std::vector<Tracked> Refiner::withoutTwins(std::vector<Tracked> poses, double distance,
                                           double support_min, std::size_t most) const {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Tracked& a, const Tracked& b) { return a.support > b.support; });
  std::vector<Tracked> kept;
  for (const auto& p : poses) {
    if (kept.size() >= most || p.support < support_min) break;
    const auto& part = *outlines_[p.part].part;
    const bool twin = std::any_of(kept.begin(), kept.end(), [&](const Tracked& k) {
      return k.part == p.part && k.face == p.face &&
             poseDistance(part, k.T_camera_part, p.T_camera_part, p.face) < distance;
    });
    if (!twin) kept.push_back(p);
  }
  return kept;
}

RefinedPose Refiner::finish(const Tracked& pose) const {
  RefinedPose out;
  out.part = pose.part;
  out.face = pose.face;
  out.T_camera_part = pose.T_camera_part;
  out.residual_px = pose.image.residual_px;
  const double variance = std::max(1e-4, out.residual_px * out.residual_px);
  Matrix6d H = pose.image.information / variance;
  H.diagonal().array() += 1e-6;
  const double r = outlines_[pose.part].part->radius();
  Vector6d unit;
  unit << r, r, r, 1.0, 1.0, 1.0;
  out.covariance =
      unit.asDiagonal() * H.ldlt().solve(Matrix6d::Identity()) * unit.asDiagonal();
  return out;
}

}  // namespace

std::vector<RefinedPose> refineCandidates(
    const EdgeMap& edges, const Camera& camera,
    const std::vector<std::shared_ptr<const PartModel>>& parts,
    const std::vector<Candidate>& candidates, const RefineParams& params, int threads) {
  const Refiner refiner(edges, camera, params, parts, threads);
  auto poses = refiner.settle(candidates);
  poses = refiner.withoutTwins(std::move(poses), 0.04, params.field_support_min, params.max_poses);
  refiner.alignAll(kWide, std::array<double, 3>{8.0, 6.0, 4.0}, &poses);
  poses = refiner.withoutTwins(std::move(poses), 0.01, params.image_support_min, params.max_poses);
  refiner.alignAll(kNarrow, std::array<double, 2>{3.0, 2.0}, &poses);
  refiner.resolveAll(&poses);
  poses = refiner.withoutTwins(std::move(poses), 0.01, params.image_support_min, params.max_poses);
  std::vector<RefinedPose> out;
  for (const auto& p : poses) out.push_back(refiner.finish(p));
  return out;
}

}  // namespace planar_bin_picking
