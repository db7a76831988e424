// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// From where to look at a located part once more: the place of the camera that lowers the
/// uncertainty of its pose most. Nothing here moves a robot.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/part/part_model.h"

#include <optional>

namespace planar_bin_picking {

/// A bin's inner space as a box; its walls hide what lies behind them.
struct ViewBin {
  Eigen::Isometry3d T_bin_base = Eigen::Isometry3d::Identity();
  Eigen::Vector3d min = Eigen::Vector3d::Zero(), max = Eigen::Vector3d::Zero();  ///< bin frame
};

/// Where the camera may go: as the calibrator's limits, for the camera in place of the flange.
struct NextViewLimits {
  /// Metres, in the base frame: the camera's centre stays in this box.
  Eigen::Vector3d box_min = Eigen::Vector3d::Zero(), box_max = Eigen::Vector3d::Zero();
  double cone_deg = 40.0;  ///< the optical axis stays within this of where it was
  /// Metres along the optical axis between which the picture is sharp.
  Distances focus;
  std::optional<ViewBin> bin;  ///< the part lies in it and is looked at through its top
};

/// @throws std::invalid_argument  an empty box, a cone outside of 0 .. 90, no focus range
void validate(const NextViewLimits& limits);

struct ViewProposal {
  /// The proposed camera, its optical axis through the part, turned about it as little as possible.
  Eigen::Isometry3d T_first_camera = Eigen::Isometry3d::Identity();
  /// Of the pose once the look has confirmed it, as RefinedPose::covariance; of what the views can
  /// tell where nothing hides the part.
  Matrix6d covariance = Matrix6d::Zero();
};

/// @param known         in the first view's frame
/// @param T_base_first  of the first view's camera
/// @return  nothing where no place within the limits shows the whole part
/// Cost: some 10 ms.
std::optional<ViewProposal> nextView(const Detection& known, const PartModel& part,
                                     const Camera& camera, const Eigen::Isometry3d& T_base_first,
                                     const NextViewLimits& limits, const LocatorParams& params);

/// What a look from there would leave of the uncertainty; nothing where the part is not all in the
/// picture, or seen too much from the side.
std::optional<Matrix6d> predictedCovariance(const Detection& known, const PartModel& part,
                                            const Camera& camera,
                                            const Eigen::Isometry3d& T_first_camera,
                                            const LocatorParams& params);

}  // namespace planar_bin_picking
