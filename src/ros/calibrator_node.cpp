// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator_ros.h"

#include <ros/ros.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "calibrator");
  // Outside the try block: with its last handle ROS shuts down, and its log falls silent.
  const ros::NodeHandle nh, pnh("~");
  try {
    planar_bin_picking_ros::CalibratorRos calibrator(nh, pnh);
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
