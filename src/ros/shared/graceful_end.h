// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The shell of a node that has a last word to say before ROS goes: a robot to stop, frames to
/// withdraw. ROS's own handlers tear the connections down at once; here whoever asks the node to
/// end sets a flag, and ROS is shut down last.

#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <string>

namespace planar_bin_picking_ros {

/// Runs a node until SIGINT, SIGTERM, SIGHUP, `rosnode kill` or another node of its name ends it.
/// @param make  makes the node's object, which is destroyed while ROS still works
/// @return  exit status: 1 where `make` throws, and the reason is logged
int runGracefully(int argc, char** argv, const std::string& name,
                  const std::function<std::shared_ptr<void>(const ros::NodeHandle& nh,
                                                            const ros::NodeHandle& pnh)>& make);

}  // namespace planar_bin_picking_ros
