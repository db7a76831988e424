// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace planar_bin_picking {

/// How much depth counts beside what lies across the line of sight, since a picture determines it
/// several times worse. The same for the normals of two poses.
inline constexpr double kDepthShare = 0.25;
/// Radii between two centres beyond which nobody asks how the parts are turned.
inline constexpr double kCentresApart = 0.2;

/// Largest distance, in radii of the part and across the line of sight, between the same points of
/// two poses of the same face; modulo the outline's rotation symmetry and its near-symmetries.
/// Depth counts a quarter.
inline double poseDistance(const PartModel& part, const Eigen::Isometry3d& T_camera_a,
                           const Eigen::Isometry3d& T_camera_b, Face face) {
  const auto& symmetry = part.symmetry();
  const double r = part.radius();
  const Eigen::Vector3d c(symmetry.center.x(), symmetry.center.y(), part.faceZ(face));
  const auto apart = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d d = a - b, ray = b.normalized();
    const double depth = d.dot(ray);
    return std::max((d - depth * ray).norm(), kDepthShare * std::abs(depth)) / r;
  };
  const Eigen::Vector3d ca = T_camera_a * c, cb = T_camera_b * c;
  const Eigen::Matrix3d &A = T_camera_a.linear(), &B = T_camera_b.linear();
  const double centre = std::max(apart(ca, cb), kDepthShare * (A.col(2) - B.col(2)).norm());
  if (centre > kCentresApart || symmetry.order == 0) return centre;
  const auto turned = [&](const Eigen::Matrix3d& S) {
    double worst = centre;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector3d a = r * (A * S).col(axis), b = r * B.col(axis);
      worst = std::max({worst, apart(ca + a, cb + b), apart(ca - a, cb - b)});
    }
    return worst;
  };
  double best = std::numeric_limits<double>::infinity();
  for (int k = 0; k < symmetry.order; ++k) {
    const Eigen::AngleAxisd S(2.0 * M_PI * k / symmetry.order, Eigen::Vector3d::UnitZ());
    best = std::min(best, turned(S.toRotationMatrix()));
  }
  for (const auto& other : part.nearSymmetries()) {
    if (!other.flips) best = std::min(best, turned(other.T_part_turned.linear()));
  }
  return best;
}

}  // namespace planar_bin_picking
