// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/refine.h"

#include "locate/evidence/inlier_score.h"
#include "locate/refine/field_alignment.h"
#include "locate/refine/refiner.h"
#include "part/part_extent.h"
#include "part/visible_face.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr SearchProfile kNarrow{4, true, 0.8};
// Pixels off the outline at which an edge no longer supports it, before narrow alignment.
constexpr double kSupportWide = 2.5;
constexpr int kSearchRounds = 2;
constexpr double kSure = 0.7;  // poses so well supported tell where edges lie

}  // namespace

Refiner::Refiner(const EdgeMap& edges, const Camera& camera, const RefineParams& params,
                 const std::vector<std::shared_ptr<const PartModel>>& parts, int threads)
    : edges_(edges), camera_(camera), params_(params), threads_(threads) {
  const auto is_shape = [](const OutlinePoint& p) { return p.kind != LoopKind::kPrint; };
  const auto is_print = [](const OutlinePoint& p) { return p.kind == LoopKind::kPrint; };
  for (const auto& part : parts) {
    const FaceOutline face{localPoints(*part, params.wide_points / 2, is_shape),
                           localPoints(*part, params.wide_points, is_shape),
                           localPoints(*part, params.image_points, is_shape)};
    outlines_.push_back({part.get(),
                         grainOf(*part),
                         localPoints(*part, params.field_points, is_shape),
                         localPoints(*part, params.image_points, is_print),
                         {face, face}});
  }
}

std::vector<Tracked> Refiner::settle(const std::vector<Candidate>& candidates) const {
  std::vector<Tracked> poses(candidates.size());
  parallelFor(static_cast<int>(candidates.size()), threads_, [&](int i) {
    const auto& c = candidates[i];
    const auto& outline = outlines_[c.part];
    const Eigen::Isometry3d T_part_centre = centreOf(*outline.part, c.face);
    const Eigen::Isometry3d T_camera_centre = c.T_camera_part * T_part_centre;
    const Field& field = edges_.fieldOf(c.part);
    const auto settled =
        settleInField(field, outline.field, outline.part->radius(), T_camera_centre,
                      params_.field_reach_radii * field.focal * outline.part->radius() /
                          T_camera_centre.translation().z(),
                      params_);
    poses[i] = {
        c.part, c.face, settled.T_camera_centre * T_part_centre.inverse(), settled.support, {}};
  });
  return poses;
}

/// Steps in the raw image, the reach shrinking.
template <std::size_t N>
void Refiner::align(const std::vector<LocalPoint>& points, const SearchProfile& reach,
                    const std::array<double, N>& tukey_px, Tracked* pose) const {
  const auto& outline = outlines_[pose->part];
  const Eigen::Isometry3d T_part_centre = centreOf(*outline.part, pose->face);
  pose->image.T_camera_centre = pose->T_camera_part * T_part_centre;
  for (const double tukey : tukey_px) {
    pose->image = stepInImage(edges_, camera_, points, solidOf(*outline.part, pose->face),
                              pose->image.T_camera_centre, reach, tukey);
  }
  pose->T_camera_part = pose->image.T_camera_centre * T_part_centre.inverse();
  pose->support = supportAt(*pose, points, reach.paired ? kSupportNarrow : kSupportWide);
}

int Refiner::wideReach(const Tracked& pose) const {
  const PartModel& part = *outlines_[pose.part].part;
  const Eigen::Vector3d centre = pose.T_camera_part * centreOf(part, pose.face).translation();
  const double radius_px = camera_.model().fx * part.radius() / centre.z();
  return std::clamp(static_cast<int>(std::lround(0.03 * radius_px)), 6, 14);
}

void Refiner::alignWide(Tracked* pose) const {
  const int reach = wideReach(*pose);
  align(outlines_[pose->part].of(pose->face).wide, {reach, false, 1.2},
        std::array<double, 3>{1.0 * reach, 0.7 * reach, 4.0}, pose);
}

void Refiner::alignNarrow(Tracked* pose) const {
  align(outlines_[pose->part].of(pose->face).fine, kNarrow, std::array<double, 2>{3.0, 2.0}, pose);
}

void Refiner::searchAround(Tracked* pose) const {
  static const std::array<std::array<double, 3>, 8> kSteps = {{{0.03, 0, 0},
                                                               {-0.03, 0, 0},
                                                               {0.06, 0, 0},
                                                               {0, 0.12, 0},
                                                               {0, -0.12, 0},
                                                               {0, 0, 0.12},
                                                               {0, 0, -0.12},
                                                               {-0.06, 0, 0}}};
  if (pose->searched || pose->support > params_.search_below) return;
  const auto& points = outlines_[pose->part].of(pose->face).coarse;
  const Eigen::Isometry3d T_part_centre = centreOf(*outlines_[pose->part].part, pose->face);
  Tracked best = *pose;
  best.support = supportAt(*pose, points, kSupportWide);
  for (const auto& step : kSteps) {
    Tracked other = *pose;
    Eigen::Isometry3d T = pose->T_camera_part * T_part_centre;
    T.translation() *= 1.0 + step[0];
    T.linear() = T.linear() * (Eigen::AngleAxisd(step[1], Eigen::Vector3d::UnitX()) *
                               Eigen::AngleAxisd(step[2], Eigen::Vector3d::UnitY()))
                                  .toRotationMatrix();
    other.T_camera_part = T * T_part_centre.inverse();
    const int reach = wideReach(other);
    align(points, {reach, false, 1.2}, std::array<double, 2>{1.0 * reach, 0.5 * reach}, &other);
    if (other.support > best.support) best = other;
  }
  alignWide(&best);
  pose->searched = best.support <= pose->support;
  if (!pose->searched) *pose = best;
}

double Refiner::supportAt(const Tracked& pose, const std::vector<LocalPoint>& points,
                          double reach_px) const {
  std::vector<EdgeHit> hits;
  const auto& part = *outlines_[pose.part].part;
  findHits(edges_, camera_, points, solidOf(part, pose.face),
           pose.T_camera_part * centreOf(part, pose.face), kNarrow, &hits);
  return meanSupport(hits, reach_px);
}

bool Refiner::isHeld(const Tracked& pose) const {
  return pose.image.used >= kFewEdges &&
         showsFace(*outlines_[pose.part].part, pose.T_camera_part, pose.face);
}

RefinedPose Refiner::finish(const Tracked& pose) const {
  RefinedPose out;
  out.part = pose.part;
  out.face = pose.face;
  out.residual_px = pose.image.residual_px;
  const PartModel& part = *outlines_[pose.part].part;
  const FaceOutline& outline = outlines_[pose.part].of(pose.face);
  const double r = part.radius();
  // This copy's own inset, as far as it is known better than that of all.
  const double own = std::pow(r * pose.image.inset_sigma, 2),
               all = std::pow(outline.inset_spread, 2);
  const double share = all / (all + own);
  const double more = share * pose.image.inset;
  out.inset = outline.inset + r * more;
  out.T_camera_part = stepped(pose.image.T_camera_centre, pose.image.per_inset * more, r) *
                      centreOf(part, pose.face).inverse();
  const double inset_sigma =
      std::sqrt(std::pow((1.0 - share) * outline.inset_sigma, 2) + (1.0 - share) * all);
  // Below what any edge is good for: a tenth of a pixel over the whole outline is never beaten.
  constexpr double kFloorPx = 0.02;
  const double floor =
      kFloorPx * pose.image.T_camera_centre.translation().z() / (camera_.model().fx * r);
  const Vector6d per_inset = pose.image.per_inset * (inset_sigma / r);
  Matrix6d covariance = pose.image.covariance + per_inset * per_inset.transpose();
  covariance.diagonal().array() += floor * floor;
  Vector6d unit;
  unit << r, r, r, 1.0, 1.0, 1.0;
  out.covariance = unit.asDiagonal() * covariance * unit.asDiagonal();
  return out;
}

std::vector<RefinedPose> refineCandidates(
    const EdgeMap& edges, const Camera& camera,
    const std::vector<std::shared_ptr<const PartModel>>& parts,
    const std::vector<Candidate>& candidates, const RefineParams& params, int threads) {
  Refiner refiner(edges, camera, params, parts, threads);
  auto poses = refiner.settle(candidates);
  poses = refiner.withoutTwins(std::move(poses), 0.04, params.field_support_min);
  refiner.forAll(&poses, [&](auto* p) { refiner.alignWide(p); });
  poses = refiner.withoutTwins(std::move(poses), 0.02, params.image_support_min);
  poses = refiner.withoutOutdone(poses);
  refiner.forAll(&poses, [&](auto* p) {
    if (p->support > kSure) refiner.alignNarrow(p);
  });
  refiner.estimateInsets(poses);
  for (int round = 0; round < kSearchRounds; ++round) {
    refiner.forAll(&poses, [&](auto* p) { refiner.searchAround(p); });
    poses = refiner.withoutTwins(std::move(poses), 0.02, params.image_support_min);
    poses = refiner.withoutOutdone(poses);
  }
  poses = refiner.withoutTwins(std::move(poses), 0.02, params.search_support_min);
  refiner.forAll(&poses, [&](auto* p) {
    refiner.alignNarrow(p);
    refiner.resolve(p);
  });
  poses = refiner.withoutTwins(std::move(poses), 0.02, params.search_support_min);
  refiner.settleTilts(&poses);
  refiner.estimateInsets(poses);
  refiner.forAll(&poses, [&](auto* p) { refiner.alignNarrow(p); });
  std::vector<RefinedPose> out;
  for (const auto& p : poses) {
    if (refiner.isHeld(p)) out.push_back(refiner.finish(p));
  }
  return out;
}

}  // namespace planar_bin_picking
