// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// tf2 as the package uses it: one transform at one moment, or the reason why there is none. Never
/// identity, never "the latest one".

#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <Eigen/Geometry>

#include <chrono>
#include <optional>
#include <string>

namespace planar_bin_picking_ros {

struct LookupResult {
  std::optional<Eigen::Isometry3d> T_target_source;
  std::string reason;  ///< tf2's words, where there is no transform
};

/// @param stamp    the image's; the robot's tf may come in later than the image, hence
/// @param timeout  how long to wait for it, wall time (ROS time may stand still)
LookupResult lookup(const tf2::BufferCore& buffer, const std::string& target,
                    const std::string& source, const ros::Time& stamp,
                    std::chrono::duration<double> timeout);

}  // namespace planar_bin_picking_ros
