// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Poses as robot controllers write them.

#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// R is the rotation matrix, its axes those of the pose in the robot's base.
enum class PoseConvention {
  kKuka,     ///< mm; A, B, C in degrees: R = Rz(A) Ry(B) Rx(C)
  kFanuc,    ///< mm; W, P, R in degrees, about the fixed x, y, z: R = Rz(R) Ry(P) Rx(W)
  kUr,       ///< metres; the rotation vector in radians
  kAbb,      ///< mm; the quaternion q1 .. q4 = w, x, y, z
  kStaubli,  ///< mm; Rx, Ry, Rz in degrees, each about the axis as turned: R = Rx Ry Rz
  kPlain,    ///< mm; roll, pitch, yaw in degrees as rpy_deg of part files: the same as Fanuc's
};

/// kuka, fanuc, ur, abb, staubli or plain; nothing for another word.
std::optional<PoseConvention> poseConvention(const std::string& name);

/// 6, or 7 with a quaternion.
std::size_t poseNumbers(PoseConvention convention);

/// Position, then orientation. Where two rotations are about one line, and only their sum counts,
/// the last of the three in the product is zero. Quaternions have w >= 0.
std::vector<double> toNumbers(const Eigen::Isometry3d& T_base_pose, PoseConvention convention);

/// @throws std::invalid_argument  too few or many, not finite, more than 100 m away, or a
///         quaternion that is not of length 1 (to 1 %)
Eigen::Isometry3d fromNumbers(const std::vector<double>& numbers, PoseConvention convention);

}  // namespace planar_bin_picking
