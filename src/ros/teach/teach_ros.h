// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Teaching pick poses in rviz: each is an interactive marker with a menu, and so is the part.

#include "planar_bin_picking/teach/taught_part.h"

#include <interactive_markers/interactive_marker_server.h>
#include <interactive_markers/menu_handler.h>
#include <planar_bin_picking/RenamePick.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <functional>
#include <set>
#include <string>

namespace planar_bin_picking_ros {

/// All of it is called from one thread.
class TeachRos {
 public:
  /// @throws std::exception  ~part or ~parts_folder is not set, or the part cannot be read
  TeachRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);
  ~TeachRos();
  TeachRos(const TeachRos&) = delete;
  TeachRos& operator=(const TeachRos&) = delete;

 private:
  using Feedback = visualization_msgs::InteractiveMarkerFeedbackConstPtr;
  using Pick = planar_bin_picking::PickPose;

  void addPartMenu();
  void addPoseMenu();
  /// An entry of a pose's menu that makes another pose of it.
  void addMove(const std::string& title, const std::function<Pick(const Pick&)>& move);
  /// Does what a menu entry says, shows what has come of it, and says why where it cannot be done.
  interactive_markers::MenuHandler::FeedbackCallback entry(
      const std::function<std::string(const visualization_msgs::InteractiveMarkerFeedback&)>& act);
  void moved(const Feedback& feedback);
  bool serveSave(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool serveRename(planar_bin_picking::RenamePick::Request& request,
                   planar_bin_picking::RenamePick::Response& response);
  /// Brings the markers up to date. @param news  what has happened, for people
  void show(const std::string& news);

  planar_bin_picking::TaughtPart taught_;
  interactive_markers::InteractiveMarkerServer server_;
  interactive_markers::MenuHandler part_menu_, pose_menu_;
  std::set<std::string> shown_;  ///< poses with a marker
  bool is_dragged_ = false;      ///< since a marker was last let go
  tf2_ros::StaticTransformBroadcaster tf_;
  ros::Publisher status_;
  ros::ServiceServer save_, rename_;
};

}  // namespace planar_bin_picking_ros
