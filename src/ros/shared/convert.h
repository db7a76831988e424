// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Messages of poses <-> the core's types; pure functions.
///
/// tf2 dictionary: T_target_source has header.frame_id = target and child_frame_id = source.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_model.h"

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <planar_bin_picking/LocatedPart.h>

#include <cstdint>

namespace planar_bin_picking_ros {

Eigen::Isometry3d fromMsg(const geometry_msgs::Transform& transform);
Eigen::Isometry3d fromMsg(const geometry_msgs::Pose& pose);
geometry_msgs::Pose toPoseMsg(const Eigen::Isometry3d& T_header_child);
geometry_msgs::Transform toTransformMsg(const Eigen::Isometry3d& T_header_child);

/// The core's covariance as a ROS message has it.
/// @param covariance       of xi = [translation; rotation] in T_camera_center * exp(xi), where the
///                         frame `center` is the part's, moved to p_center_part
/// @param R_header_part    rotation of the pose in the message
/// @param center           centre of the visible outline in the part frame
/// @return  of x, y, z of the part's origin and of the rotation about the fixed axes of the
/// header's
///          frame, to first order
planar_bin_picking::Matrix6d fixedAxesCovariance(const planar_bin_picking::Matrix6d& covariance,
                                                 const Eigen::Matrix3d& R_header_part,
                                                 const Eigen::Vector3d& center);

/// One detection as the robot program gets it. Header and child_frame are the caller's.
planar_bin_picking::LocatedPart toMsg(const planar_bin_picking::Detection& detection,
                                      const planar_bin_picking::PartModel& part,
                                      const Eigen::Isometry3d& T_header_camera);

/// As RefusedPart has it, such as "TILT".
const char* nameOfReason(std::uint8_t reason);

}  // namespace planar_bin_picking_ros
