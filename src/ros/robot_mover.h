// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The robot as the calibrator sees it: go there, or stop at once. The client of MoveRobot.

#include <planar_bin_picking/MoveRobot.h>
#include <ros/node_handle.h>

#include <Eigen/Geometry>

#include <atomic>
#include <string>

namespace planar_bin_picking_ros {

class RobotMover {
 public:
  /// @param nh  the service's name is resolved in it
  RobotMover(const ros::NodeHandle& nh, const std::string& base_frame, double speed_scale,
             double timeout);

  /// Blocks until the robot has answered.
  /// @param stop  set by another thread to give up
  /// @throws std::runtime_error  no such service, no answer in time (the robot is told to stop),
  /// stopped
  planar_bin_picking::MoveRobot::Response move(const Eigen::Isometry3d& T_base_flange,
                                               const std::atomic<bool>& stop);

  /// Tells the robot to stop where it is, beside a move that is under way; any thread.
  /// @return  whether it confirmed
  bool stopNow();

 private:
  const std::string service_, base_frame_;
  const double speed_scale_, timeout_;
};

}  // namespace planar_bin_picking_ros
