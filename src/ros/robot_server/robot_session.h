// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One robot controller's talk: its lines to calls of the locator, answers to lines.

#include "planar_bin_picking/robot/robot_line.h"
#include "robot_server/robot_server_params.h"

#include <planar_bin_picking/LocatedPart.h>
#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace planar_bin_picking_ros {

/// What all sessions share: what does not change, and the one robot's pose on tf.
class RobotCell {
 public:
  /// @throws std::invalid_argument  naming the key: no such convention, a tool that is no pose
  RobotCell(const RobotServerParams& params, const ros::NodeHandle& nh);

  const RobotServerParams params;
  const planar_bin_picking::PoseConvention convention;
  const Eigen::Isometry3d T_tool_flange;
  ros::NodeHandle nh;
  tf2_ros::TransformBroadcaster tf;
  std::mutex flange;  ///< held by the call whose flange stands on tf
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
  /// Goes to the first that waits and can be picked.
  std::string offer(const std::string& otherwise);
  std::string text(planar_bin_picking::RobotCode code, const std::string& words) const;

  RobotCell& cell_;
  std::deque<planar_bin_picking::LocatedPart> waiting_;     ///< of the latest answer
  std::optional<planar_bin_picking::LocatedPart> current_;  ///< sent, and not reported yet
};

}  // namespace planar_bin_picking_ros
