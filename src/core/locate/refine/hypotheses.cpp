// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/plane_pose.h"
#include "locate/evidence/inlier_score.h"
#include "locate/evidence/print_evidence.h"
#include "locate/evidence/wall_evidence.h"
#include "locate/refine/field_alignment.h"
#include "locate/refine/refiner.h"
#include "part/pose_distance.h"
#include "part/visible_face.h"

#include <algorithm>
#include <cmath>
#include <utility>

/// Refiner's choice between poses that look alike.

namespace planar_bin_picking {
namespace {

constexpr double kTiltUnsure =
    0.03;  // a lead in support that decides nothing about the tilt's sign

/// The pose and its tilt twin as the lookalike's; what the image said was about the pose itself.
Tracked twinOf(const Tracked& pose, const NearSymmetry& other) {
  Tracked twin = pose;
  twin.T_camera_part = pose.T_camera_part * other.T_part_turned;
  twin.T_camera_twin = pose.T_camera_twin * other.T_part_turned;
  twin.image = {};
  twin.searched = false;
  if (other.flips) twin.face = pose.face == Face::kFront ? Face::kBack : Face::kFront;
  return twin;
}

}  // namespace

std::vector<Tracked> Refiner::withoutTwins(std::vector<Tracked> poses, double distance,
                                           double support_min) const {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Tracked& a, const Tracked& b) { return a.support > b.support; });
  std::vector<Tracked> kept;
  std::vector<int> count(outlines_.size(), 0);
  for (const auto& p : poses) {
    if (p.support < support_min) break;
    if (count[p.part] >= params_.max_poses) continue;
    const auto& part = *outlines_[p.part].part;
    const bool twin = std::any_of(kept.begin(), kept.end(), [&](const Tracked& k) {
      return k.part == p.part && k.face == p.face &&
             poseDistance(part, k.T_camera_part, p.T_camera_part, p.face) < distance;
    });
    if (twin) continue;
    kept.push_back(p);
    ++count[p.part];
  }
  return kept;
}

std::vector<Tracked> Refiner::withoutOutdone(const std::vector<Tracked>& poses) const {
  constexpr double kSamePlace = 0.35, kClearly = 0.12;  // of the part's grain; support
  std::vector<Tracked> kept;
  const auto centre = [&](const Tracked& p) -> Eigen::Vector3d {
    return p.T_camera_part * centreOf(*outlines_[p.part].part, p.face).translation();
  };
  for (const auto& p : poses) {
    const Eigen::Vector3d c = centre(p);
    const double reach = kSamePlace * outlines_[p.part].grain / c.z();
    const bool outdone = std::any_of(poses.begin(), poses.end(), [&](const Tracked& o) {
      return o.part == p.part && o.support > p.support + kClearly &&
             (centre(o).hnormalized() - c.hnormalized()).norm() < reach;
    });
    if (!outdone) kept.push_back(p);
  }
  return kept;
}

void Refiner::resolve(Tracked* pose) const {
  resolveTilt(pose);
  resolveShape(pose);
  resolvePrint(pose);
}

namespace {

std::vector<LocalPoint> pointsAt(const PartModel& part, const std::vector<int>& indices) {
  constexpr std::size_t kEnough = 64;
  const std::size_t stride = 1 + indices.size() / kEnough;
  std::vector<LocalPoint> points;
  for (std::size_t i = 0; i < indices.size(); i += stride) {
    points.push_back(localPoint(part, indices[i]));
  }
  return points;
}

}  // namespace

double Refiner::supportOn(const Tracked& pose, const PartModel& part,
                          const std::vector<int>& indices) const {
  return supportAt(pose, pointsAt(part, indices), kSupportNarrow);
}

double Refiner::supportInFieldOn(const Tracked& pose, const PartModel& part,
                                 const std::vector<int>& indices) const {
  constexpr double kReachPx = 2.0;
  return supportInField(edges_.fieldOf(pose.part), pointsAt(part, indices), part.radius(),
                        pose.T_camera_part * centreOf(part, pose.face), kReachPx);
}

/// The plane that looks nearly the same: tilted the other way about the line of sight ([4]).
std::optional<Tracked> Refiner::tiltTwin(const Tracked& pose) const {
  constexpr double kTilted = 0.07;    // normals closer than this (4 degrees) refine into each other
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

void Refiner::resolveTilt(Tracked* pose) const {
  constexpr double kWall = 0.2;  // a wall's lower edge is often lost in a shadow
  const auto wallOf = [&](const Tracked& p) {
    const auto& outline = outlines_[p.part];
    return wallSupport(edges_, camera_, outline.of(p.face).fine, solidOf(*outline.part, p.face),
                       p.T_camera_part * centreOf(*outline.part, p.face));
  };
  auto twin = tiltTwin(*pose);
  if (!twin) return;
  alignWide(&*twin);
  if (twin->support < pose->support - 0.1) return;
  alignNarrow(&*twin);
  double gain = twin->support - pose->support;
  if (std::abs(gain) < kTiltUnsure) {
    const auto wall = wallOf(*pose), twin_wall = wallOf(*twin);
    if (wall && twin_wall) gain += kWall * (*twin_wall - *wall);
  }
  const bool apart =
      (twin->T_camera_part.linear().col(2) - pose->T_camera_part.linear().col(2)).norm() > 0.05;
  twin->T_camera_twin = pose->T_camera_part;
  pose->T_camera_twin = twin->T_camera_part;
  twin->ambiguous = pose->ambiguous = apart && std::abs(gain) < kTiltUnsure;
  if (gain > 0.0) *pose = *twin;
}

/// What tells a pose from a lookalike decides; first in the field, where a few points cost little.
void Refiner::resolveShape(Tracked* pose) const {
  constexpr double kHopeless = -0.3;  // what an alignment does not make up for
  constexpr std::size_t kMost = 8;
  const auto& part = *outlines_[pose->part].part;
  struct Rival {
    double gain;
    const NearSymmetry* other;
  };
  std::vector<Rival> rivals;
  for (const auto& other : part.nearSymmetries()) {
    if (other.exact) continue;
    const double gain = supportInFieldOn(twinOf(*pose, other), part, other.only_turned) -
                        supportInFieldOn(*pose, part, other.only_part);
    if (gain > kHopeless) rivals.push_back({gain, &other});
  }
  std::stable_sort(rivals.begin(), rivals.end(),
                   [](const Rival& a, const Rival& b) { return a.gain > b.gain; });
  if (rivals.size() > kMost) rivals.resize(kMost);
  Tracked best = *pose;
  double best_gain = 0.0;
  for (const auto& [gain, other] : rivals) {
    Tracked twin = twinOf(*pose, *other);
    alignNarrow(&twin);
    const double gained =
        supportOn(twin, part, other->only_turned) - supportOn(*pose, part, other->only_part);
    if (gained > best_gain) {
      best_gain = gained;
      best = twin;
    }
  }
  *pose = best;
}

/// Of a printed part the front is up where at least half of the print is borne out.
void Refiner::resolvePrint(Tracked* pose) const {
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
  for (const auto& other : outline.part->nearSymmetries()) {
    if (other.exact) consider(twinOf(*pose, other));
  }
  *pose = print > 0.5 ? front : back;
  if (pose->image.used == 0) alignNarrow(pose);  // a lookalike
}

void Refiner::settleTilts(std::vector<Tracked>* poses) const {
  constexpr double kAlike = 0.2;  // about 12 degrees
  Eigen::Vector3d common = Eigen::Vector3d::Zero();
  double most = 0.0;
  for (const auto& p : *poses) {
    const Eigen::Vector3d n = normalOf(p.T_camera_part, p.face);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weight = 0.0;
    for (const auto& o : *poses) {
      const double w = o.support * (o.ambiguous ? 0.3 : 1.0);
      const Eigen::Vector3d other = normalOf(o.T_camera_part, o.face);
      if ((other - n).norm() > kAlike) continue;
      weight += w;
      sum += w * other;
    }
    if (weight > most) {
      most = weight;
      common = sum.normalized();
    }
  }
  for (auto& p : *poses) {
    if (!p.ambiguous) continue;
    const double here = (normalOf(p.T_camera_part, p.face) - common).norm();
    const double twin = (normalOf(p.T_camera_twin, p.face) - common).norm();
    if (twin >= 0.6 * here) continue;
    std::swap(p.T_camera_part, p.T_camera_twin);
    alignNarrow(&p);
  }
}

}  // namespace planar_bin_picking
