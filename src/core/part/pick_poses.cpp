// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/pick_poses.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMostTurns =
    12;  // copies of a pose: every 30 degrees a robot finds one that it reaches
constexpr double kNear = 1e-4;  // metres and radians: what a drawing's numbers may be rounded to

/// A motion after which the part looks the same.
struct Turn {
  Eigen::Isometry3d T_part_turned = Eigen::Isometry3d::Identity();
  bool flips = false;
};

/// Identity first, then all that leave the same face up.
std::vector<Turn> turnsOf(const Symmetry& symmetry, double thickness) {
  const int order = symmetry.order == 0 ? kMostTurns : symmetry.order;
  const int stride = (order + kMostTurns - 1) / kMostTurns;
  const Eigen::Translation3d center(symmetry.center.x(), symmetry.center.y(), -0.5 * thickness);
  const Eigen::AngleAxisd flip(
      kPi, Eigen::Vector3d(std::cos(symmetry.mirror_axis), std::sin(symmetry.mirror_axis), 0.0));
  std::vector<Turn> turns;
  for (const bool flips : {false, true}) {
    if (flips && !symmetry.mirror) break;
    for (int k = 0; k < order; k += stride) {
      const Eigen::AngleAxisd turn(2.0 * kPi * k / order, Eigen::Vector3d::UnitZ());
      const Eigen::Quaterniond rotation = flips ? turn * flip : Eigen::Quaterniond(turn);
      turns.push_back({center * rotation * center.inverse(), flips});
    }
  }
  return turns;
}

FaceFilter flipped(FaceFilter face) {
  if (face == FaceFilter::kAny) return face;
  return face == FaceFilter::kFront ? FaceFilter::kBack : FaceFilter::kFront;
}

bool isSame(const PickPose& a, const PickPose& b) {
  return a.face == b.face && a.T_part_pick.isApprox(b.T_part_pick, kNear);
}

}  // namespace

std::vector<PickPose> withSymmetricCopies(const std::vector<PickPose>& poses,
                                          const Symmetry& symmetry, double thickness) {
  const std::vector<Turn> turns = turnsOf(symmetry, thickness);
  std::vector<PickPose> all;
  for (const PickPose& pose : poses) {
    int copies = 0;
    for (const Turn& turn : turns) {
      const bool is_given = &turn == &turns.front();
      if (!is_given && !pose.symmetric) break;
      PickPose copy = pose;
      copy.T_part_pick = turn.T_part_turned * pose.T_part_pick;
      if (turn.flips) copy.face = flipped(pose.face);
      const auto stands = [&](const PickPose& other) { return isSame(other, copy); };
      const bool is_known = std::any_of(all.begin(), all.end(), stands) ||
                            (!is_given && std::any_of(poses.begin(), poses.end(), stands));
      if (is_known && !is_given) continue;
      ++copies;
      if (!is_given) copy.name += "@" + std::to_string(copies);
      all.push_back(std::move(copy));
    }
  }
  return all;
}

}  // namespace planar_bin_picking
