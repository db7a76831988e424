// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/refine.h"

#include "evidence.h"
#include "parallel.h"
#include "plane_pose.h"
#include "pose_distance.h"
#include "print_evidence.h"
#include "refine_field.h"
#include "refine_image.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <optional>

namespace planar_bin_picking {
namespace {

constexpr ImageReach kNarrow{4, true, 0.8};
constexpr double kTiltUnsure =
    0.03;  // a lead in support that decides nothing about the tilt's sign

/// A pose on its way through the levels, with its support at the last one.
struct Tracked {
  std::size_t part;
  Face face;
  Eigen::Isometry3d T_camera_part;
  double support;
  ImagePose image;
  /// The same, tilted the other way, where the image cannot tell (else as T_camera_part).
  Eigen::Isometry3d T_camera_twin = Eigen::Isometry3d::Identity();
  bool ambiguous = false;
};

/// What the levels need of a part, made once per call.
struct Outline {
  const PartModel* part;
  std::vector<LocalPoint> field, wide, fine, print;
  double inset = 0.0, inset_sigma = 0.0;  // metres
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
                           localPoints(*part, params.wide_points, is_shape),
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
      const auto settled = settleInField(
          edges_.field, outline.field, outline.part->radius(), c.T_camera_part * T_part_centre,
          params_.field_reach_radii * edges_.field.focal * outline.part->radius() /
              c.T_camera_part.translation().z(),
          params_);
      poses[i] = {
          c.part, c.face, settled.T_camera_centre * T_part_centre.inverse(), settled.support, {}};
    });
    return poses;
  }

  /// Steps in the raw image, the reach shrinking.
  template <std::size_t N>
  void align(const std::vector<LocalPoint>& points, const ImageReach& reach,
             const std::array<double, N>& tukey_px, Tracked* pose) const {
    const auto& outline = outlines_[pose->part];
    const Eigen::Isometry3d T_part_centre = centreOf(*outline.part, pose->face);
    pose->image.T_camera_centre = pose->T_camera_part * T_part_centre;
    for (const double tukey : tukey_px) {
      pose->image = stepInImage(edges_, camera_, points, outline.part->radius(),
                                pose->image.T_camera_centre, reach, tukey);
    }
    pose->T_camera_part = pose->image.T_camera_centre * T_part_centre.inverse();
    pose->support = supportAt(*pose, points);
  }

  /// From what the field leaves (a small share of the part's size) to within the narrow reach.
  void alignWide(Tracked* pose) const {
    const double radius_px = camera_.model().fx * outlines_[pose->part].part->radius() /
                             pose->T_camera_part.translation().z();
    const int reach = std::clamp(static_cast<int>(std::lround(0.03 * radius_px)), 6, 14);
    align(outlines_[pose->part].wide, {reach, false, 1.2},
          std::array<double, 3>{1.0 * reach, 0.7 * reach, 4.0}, pose);
  }

  void alignNarrow(Tracked* pose) const {
    align(outlines_[pose->part].fine, kNarrow, std::array<double, 2>{3.0, 2.0}, pose);
  }

  template <class Step>
  void forAll(std::vector<Tracked>* poses, Step&& step) const {
    parallelFor(static_cast<int>(poses->size()), threads_, [&](int i) { step(&(*poses)[i]); });
  }

  /// Restarts about a settled pose, since a neighbour's edge or a shadow may hold a side of the
  /// outline and with it the pose: farther and nearer ([1] Sec. III-E goes farther only), tilted to
  /// all sides.
  void searchAround(Tracked* pose) const {
    static const std::array<std::array<double, 3>, 8> kSteps = {{{0.03, 0, 0},
                                                                 {-0.03, 0, 0},
                                                                 {0.06, 0, 0},
                                                                 {0, 0.12, 0},
                                                                 {0, -0.12, 0},
                                                                 {0, 0, 0.12},
                                                                 {0, 0, -0.12},
                                                                 {-0.06, 0, 0}}};
    const Eigen::Isometry3d T_part_centre = centreOf(*outlines_[pose->part].part, pose->face);
    for (int round = 0; round < 2; ++round) {
      const Tracked from = *pose;
      for (const auto& step : kSteps) {
        if (pose->support > params_.search_below) return;
        Tracked other = from;
        Eigen::Isometry3d T = from.T_camera_part * T_part_centre;
        T.translation() *= 1.0 + step[0];
        T.linear() = T.linear() * (Eigen::AngleAxisd(step[1], Eigen::Vector3d::UnitX()) *
                                   Eigen::AngleAxisd(step[2], Eigen::Vector3d::UnitY()))
                                      .toRotationMatrix();
        other.T_camera_part = T * T_part_centre.inverse();
        alignWide(&other);
        if (other.support > pose->support) *pose = other;
      }
      if (pose->support < from.support + 0.02) return;
    }
  }

  /// Without those that a clearly better pose of the same place outdoes.
  std::vector<Tracked> withoutOutdone(const std::vector<Tracked>& poses) const;

  /// Each pose gives way to its best lookalike.
  void resolve(Tracked* pose) const {
    resolveTilt(pose);
    resolveShape(pose);
    resolvePrint(pose);
  }

  std::vector<Tracked> withoutTwins(std::vector<Tracked> poses, double distance, double support_min,
                                    std::size_t most) const;
  RefinedPose finish(const Tracked& pose) const;

  /// How far the strongest gradient lies inside the drawn outline, metres: a bevelled or rounded
  /// cut edge shifts all edges of all copies by about the same. One number per part and image, from
  /// all well supported poses; it counts as unknown +- kPrior beforehand.
  void estimateInset(const std::vector<Tracked>& poses, std::size_t part) {
    constexpr double kPrior = 0.15e-3, kSpread = 0.05e-3;
    double sum = 0.0, weight = 1.0 / (kPrior * kPrior);
    const double radius = outlines_[part].part->radius();
    for (const auto& p : poses) {
      if (p.part != part || p.support < 0.7 || p.image.inset_information <= 0.0) continue;
      const double noise = radius * std::max(0.1, p.image.residual_px);
      const double variance = noise * noise / p.image.inset_information + kSpread * kSpread;
      sum += radius * p.image.inset / variance;
      weight += 1.0 / variance;
    }
    applyInset(part, sum / weight, std::sqrt(1.0 / weight));
  }

  /// Parts rest on one another and on one floor: where the image cannot tell the tilt's sign, the
  /// one nearer to the way most parts lie is taken.
  void settleTilts(std::vector<Tracked>* poses) const {
    constexpr double kAlike = 0.2;  // about 12 degrees
    const auto up = [](const Eigen::Isometry3d& T) -> Eigen::Vector3d {
      return T.linear().col(2) * (T.linear()(2, 2) > 0.0 ? -1.0 : 1.0);
    };
    Eigen::Vector3d common = Eigen::Vector3d::Zero();
    double most = 0.0;
    for (const auto& p : *poses) {
      const Eigen::Vector3d n = up(p.T_camera_part);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double weight = 0.0;
      for (const auto& o : *poses) {
        const double w = o.support * (o.ambiguous ? 0.3 : 1.0);
        if ((up(o.T_camera_part) - n).norm() > kAlike) continue;
        weight += w;
        sum += w * up(o.T_camera_part);
      }
      if (weight > most) {
        most = weight;
        common = sum.normalized();
      }
    }
    for (auto& p : *poses) {
      if (!p.ambiguous) continue;
      const double here = (up(p.T_camera_part) - common).norm();
      const double twin = (up(p.T_camera_twin) - common).norm();
      if (twin < 0.6 * here) std::swap(p.T_camera_part, p.T_camera_twin);
    }
  }

  void applyInset(std::size_t part, double inset, double sigma) {
    Outline& outline = outlines_[part];
    outline.inset = inset;
    outline.inset_sigma = sigma;
    for (auto* points : {&outline.wide, &outline.fine}) {
      moveInward(inset / outline.part->radius(), points);
    }
  }

 private:
  double supportAt(const Tracked& pose, const std::vector<LocalPoint>& points) const {
    std::vector<EdgeHit> hits;
    const auto& part = *outlines_[pose.part].part;
    findHits(edges_, camera_, points, part.radius(), pose.T_camera_part * centreOf(part, pose.face),
             kNarrow, &hits);
    return meanSupport(hits, 2.5);
  }

  double supportOn(const Tracked& pose, const PartModel& part,
                   const std::vector<int>& indices) const {
    std::vector<LocalPoint> points;
    for (const int i : indices) points.push_back(localPoint(part, i));
    return supportAt(pose, points);
  }

  static Tracked twinOf(const Tracked& pose, const Lookalike& other) {
    Tracked twin = pose;
    twin.T_camera_part = pose.T_camera_part * other.T_part_lookalike;
    if (other.flips) twin.face = pose.face == Face::kFront ? Face::kBack : Face::kFront;
    return twin;
  }

  /// The plane that looks nearly the same: tilted the other way about the line of sight ([4]).
  std::optional<Tracked> tiltTwin(const Tracked& pose) const {
    constexpr double kTilted = 0.07;  // normals closer than this (4 degrees) refine into each other
    constexpr double kSlackDeg = 10.0;  // a start only: it may settle within the limit
    const Eigen::Isometry3d T_part_centre = centreOf(*outlines_[pose.part].part, pose.face);
    const Eigen::Isometry3d T = pose.T_camera_part * T_part_centre;
    const Eigen::Vector2d p = T.translation().hnormalized();
    Eigen::Matrix<double, 2, 3> project;
    project << 1, 0, -p.x(), 0, 1, -p.y();
    const Eigen::Matrix2d A = project * T.linear().leftCols<2>() / T.translation().z();
    const auto poses = posesFromAffine(A, p);
    const auto apart = [&](int k) { return (poses[k].linear().col(2) - T.linear().col(2)).norm(); };
    const auto& other = poses[apart(0) > apart(1) ? 0 : 1];
    const double tilt = std::acos(std::min(1.0, std::abs(other.linear()(2, 2))));
    if ((other.linear().col(2) - T.linear().col(2)).norm() < kTilted ||
        tilt > (params_.tilt_limit_deg + kSlackDeg) * M_PI / 180.0) {
      return std::nullopt;
    }
    Tracked twin = pose;
    twin.T_camera_part = other * T_part_centre.inverse();
    return twin;
  }

  void resolveTilt(Tracked* pose) const {
    auto twin = tiltTwin(*pose);
    if (!twin) return;
    alignWide(&*twin);
    if (twin->support < pose->support - 0.1) return;
    alignNarrow(&*twin);
    const double gain = twin->support - pose->support;
    const bool apart =
        (twin->T_camera_part.linear().col(2) - pose->T_camera_part.linear().col(2)).norm() > 0.05;
    twin->T_camera_twin = pose->T_camera_part;
    pose->T_camera_twin = twin->T_camera_part;
    twin->ambiguous = pose->ambiguous = apart && std::abs(gain) < kTiltUnsure;
    if (gain > 0.0) *pose = *twin;
  }

  void resolveShape(Tracked* pose) const {
    Tracked best = *pose;
    double best_gain = 0.0;
    const auto& part = *outlines_[pose->part].part;
    const auto gain = [&](const Tracked& twin, const Lookalike& other) {
      return supportOn(twin, part, other.only_lookalike) - supportOn(*pose, part, other.only_part);
    };
    for (const auto& other : part.lookalikes()) {
      if (other.exact) continue;
      Tracked twin = twinOf(*pose, other);
      constexpr double kHopeless = -0.3;  // what an alignment does not make up for
      if (gain(twin, other) < std::max(kHopeless, best_gain - 0.5)) continue;
      alignNarrow(&twin);
      const double gained = gain(twin, other);
      if (gained > best_gain) {
        best_gain = gained;
        best = twin;
      }
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
      const double support = printSupport(edges_, camera_, outline.print, outline.part->radius(),
                                          twin.T_camera_part * centreOf(*outline.part, twin.face));
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

std::vector<Tracked> Refiner::withoutOutdone(const std::vector<Tracked>& poses) const {
  constexpr double kSamePlace = 0.35, kClearly = 0.12;  // radii; support
  std::vector<Tracked> kept;
  const auto centre = [&](const Tracked& p) -> Eigen::Vector3d {
    return p.T_camera_part * centreOf(*outlines_[p.part].part, p.face).translation();
  };
  for (const auto& p : poses) {
    const Eigen::Vector3d c = centre(p);
    const double reach = kSamePlace * outlines_[p.part].part->radius() / c.z();
    const bool outdone = std::any_of(poses.begin(), poses.end(), [&](const Tracked& o) {
      return o.part == p.part && o.support > p.support + kClearly &&
             (centre(o).hnormalized() - c.hnormalized()).norm() < reach;
    });
    if (!outdone) kept.push_back(p);
  }
  return kept;
}

RefinedPose Refiner::finish(const Tracked& pose) const {
  RefinedPose out;
  out.part = pose.part;
  out.face = pose.face;
  out.T_camera_part = pose.T_camera_part;
  out.residual_px = pose.image.residual_px;
  const Outline& outline = outlines_[pose.part];
  const double r = outline.part->radius();
  out.inset = outline.inset;
  // Below what any edge is good for: a tenth of a pixel over the whole outline is never beaten.
  constexpr double kFloorPx = 0.02;
  const double floor = kFloorPx * pose.T_camera_part.translation().z() / (camera_.model().fx * r);
  const Vector6d per_inset = pose.image.per_inset * (outline.inset_sigma / r);
  Matrix6d covariance = pose.image.covariance + per_inset * per_inset.transpose();
  covariance.diagonal().array() += floor * floor;
  Vector6d unit;
  unit << r, r, r, 1.0, 1.0, 1.0;
  out.covariance = unit.asDiagonal() * covariance * unit.asDiagonal();
  return out;
}

}  // namespace

std::vector<RefinedPose> refineCandidates(
    const EdgeMap& edges, const Camera& camera,
    const std::vector<std::shared_ptr<const PartModel>>& parts,
    const std::vector<Candidate>& candidates, const RefineParams& params, int threads) {
  Refiner refiner(edges, camera, params, parts, threads);
  auto poses = refiner.settle(candidates);
  poses = refiner.withoutTwins(std::move(poses), 0.04, params.field_support_min, params.max_poses);
  refiner.forAll(&poses, [&](auto* p) { refiner.alignWide(p); });
  poses = refiner.withoutTwins(std::move(poses), 0.02, params.image_support_min, params.max_poses);
  poses = refiner.withoutOutdone(poses);
  refiner.forAll(&poses, [&](auto* p) { refiner.searchAround(p); });
  poses = refiner.withoutTwins(std::move(poses), 0.02, params.search_support_min, params.max_poses);
  poses = refiner.withoutOutdone(poses);
  refiner.forAll(&poses, [&](auto* p) {
    refiner.alignNarrow(p);
    refiner.resolve(p);
  });
  poses = refiner.withoutTwins(std::move(poses), 0.02, params.search_support_min, params.max_poses);
  refiner.settleTilts(&poses);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    refiner.estimateInset(poses, k);
  }
  refiner.forAll(&poses, [&](auto* p) { refiner.alignNarrow(p); });
  std::vector<RefinedPose> out;
  for (const auto& p : poses) out.push_back(refiner.finish(p));
  return out;
}

}  // namespace planar_bin_picking
