// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One robot controller's talk: its lines to calls of the locator and of the calibrator, answers to
/// lines.

#include "planar_bin_picking/robot/robot_line.h"
#include "robot_server/robot_server_params.h"

#include <planar_bin_picking/LocatedPart.h>
#include <ros/node_handle.h>
#include <std_msgs/String.h>

#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace planar_bin_picking_ros {

/// What all sessions share: what does not change, and what the calibrator says of itself.
class RobotCell {
 public:
  /// @throws std::invalid_argument  naming the key: no such convention, a tool that is no pose
  RobotCell(const RobotServerParams& params, const ros::NodeHandle& nh);

  const RobotServerParams params;
  const planar_bin_picking::PoseConvention convention;
  const Eigen::Isometry3d T_tool_flange;
  ros::NodeHandle nh;

  std::size_t numbersInLine() const;  ///< of one with a pose

  /// As on the calibrator's ~status; "" where nobody has said anything.
  std::string calibration() const;

 private:
  mutable std::mutex mutex_;
  std::string calibration_;
  ros::Subscriber status_;
};

class RobotSession {
 public:
  explicit RobotSession(RobotCell& cell) : cell_(cell) {}

  /// Never throws: what is wrong becomes an answer.
  std::string answer(const std::string& line);

 private:
  std::string locate(const planar_bin_picking::RobotCommand& command);
  std::string next();
  std::string report(bool success);
  std::string calibrate(const std::string& step);
  /// Goes to the first that waits and can be picked.
  std::string offer(const std::string& otherwise);
  planar_bin_picking::RobotPose poseOf(const planar_bin_picking::LocatedPick& pick) const;
  std::string text(planar_bin_picking::RobotCode code, const std::string& words) const;

  RobotCell& cell_;
  std::deque<planar_bin_picking::LocatedPart> waiting_;     ///< of the latest answer
  std::optional<planar_bin_picking::LocatedPart> current_;  ///< sent, and not reported yet
};

}  // namespace planar_bin_picking_ros
