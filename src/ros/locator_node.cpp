// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator_ros.h"

#include <ros/ros.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "locator");
  try {
    planar_bin_picking_ros::LocatorRos locator(ros::NodeHandle(), ros::NodeHandle("~"));
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
