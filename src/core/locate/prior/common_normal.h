// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The normal that most parts of a picture share, as a prior on the tilt of a slender part about
/// its length.
///
/// Such a part tells its normal along its length well, across it hardly. Those that lie in several
/// directions tell both together, with a floor that is seen obliquely, too.

#include "planar_bin_picking/base/types.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace planar_bin_picking {

struct MeasuredNormal {
  Eigen::Vector3d normal_camera;
  Eigen::Matrix3d covariance;  ///< rad^2, camera axes
};

/// @param rotation  covariance of a turn of the part, its axes, rad^2
/// @param length    of a slender part, about which its tilt counts as unknown
MeasuredNormal measuredNormal(const Eigen::Isometry3d& T_camera_part, Face face,
                              const Eigen::Matrix3d& rotation,
                              const std::optional<Eigen::Vector2d>& length);

struct CommonNormal {
  Eigen::Vector3d normal = -Eigen::Vector3d::UnitZ();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< a radian: nothing is known
  double spread = 0.0;  ///< of those that share it, rad per axis
  double parts = 0.0;   ///< that share it, beyond what it takes to determine it; 0 = none is known
};

/// As all but one tell it. Cost: O(normals).
CommonNormal commonNormal(const std::vector<MeasuredNormal>& normals, std::size_t left_out);

/// Logarithm of the density of a tilt but for a constant.
/// @param across      unit vector in which the normal moves with the tilt
/// @param sight_tilt  from the line of sight, rad: what the camera looks at most likely faces it
double logTiltPrior(const CommonNormal& common, const Eigen::Vector3d& normal_camera,
                    const Eigen::Vector3d& across, double sight_tilt);

}  // namespace planar_bin_picking
