// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The corners of a region as handles that one drags in rviz, each with a menu.

#include "planar_bin_picking/bin/region.h"

#include <interactive_markers/interactive_marker_server.h>
#include <interactive_markers/menu_handler.h>
#include <ros/node_handle.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace planar_bin_picking_ros {

class RegionHandles {
 public:
  /// What is done with a corner, counted from 0; it may be gone by then.
  struct Actions {
    /// @param place   in the frame of the markers
    /// @param is_end  the mouse has let it go
    std::function<void(std::size_t corner, const Eigen::Vector3d& place, bool is_end)> move;
    std::function<void(std::size_t corner)> insert, remove;  ///< one behind it; it
    std::function<void()> save, clear;
  };

  /// @param pnh  its callback queue does what is wanted: rviz is answered in a thread that holds
  ///             the server's own lock
  RegionHandles(const ros::NodeHandle& pnh, std::string frame, Actions actions);
  ~RegionHandles();
  RegionHandles(const RegionHandles&) = delete;
  RegionHandles& operator=(const RegionHandles&) = delete;

  /// In place of those that were shown; none for an empty outline. Not to be called from the
  /// thread that answers rviz.
  void show(const planar_bin_picking::RegionOutline& corners,
            const Eigen::Isometry3d& T_frame_region);

 private:
  using Feedback = visualization_msgs::InteractiveMarkerFeedbackConstPtr;
  void post(std::function<void()> act);
  /// Of a corner's marker; nothing where it is none.
  void onCorner(const Feedback& feedback, const std::function<void(std::size_t)>& act);
  void moved(const Feedback& feedback);

  ros::NodeHandle pnh_;
  const std::string frame_;
  const Actions actions_;
  interactive_markers::MenuHandler menu_;
  std::unique_ptr<interactive_markers::InteractiveMarkerServer> server_;
};

}  // namespace planar_bin_picking_ros
