// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Publishes the calibrator's hand_eye.yaml (parameter ~file) as a static transform. Refuses one
/// whose verdict is POOR, unless ~accept_poor, and one older than ~max_age_days, where that is set.

#include "hand_eye/calibration_age.h"
#include "planar_bin_picking/calibrate/calibration_file.h"
#include "shared/convert.h"

#include <ros/ros.h>
#include <tf2_ros/static_transform_broadcaster.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "hand_eye");
  const ros::NodeHandle pnh("~");
  try {
    std::string path;
    if (!pnh.getParam("file", path)) throw std::invalid_argument("~file is not set: hand_eye.yaml");
    const auto file = planar_bin_picking::loadHandEye(path);
    planar_bin_picking_ros::checkUsable(path, pnh.param("accept_poor", false),
                                        pnh.param("max_age_days", 0.0));
    tf2_ros::StaticTransformBroadcaster broadcaster;
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = ros::Time::now();
    transform.header.frame_id = file.parent_frame;
    transform.child_frame_id = file.child_frame;
    transform.transform = planar_bin_picking_ros::toTransformMsg(file.T_parent_child);
    broadcaster.sendTransform(transform);
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
