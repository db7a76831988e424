// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One call's result and what it was found in: all that is published about it.

#include "input/image_inbox.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/pick/tool_room.h"

#include <planar_bin_picking/LocatedPart.h>
#include <planar_bin_picking/RefusedPart.h>
#include <ros/time.h>
#include <std_msgs/Header.h>

#include <opencv2/core/mat.hpp>

#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

/// The picture in which parts were located that have been looked at again since.
struct FirstPicture {
  cv::Mat grey;
  planar_bin_picking::Camera camera;
  Eigen::Isometry3d T_this_now;  ///< from the camera of the answer's own picture
};

/// A located part as the robot program knows it.
struct FormerPart {
  ros::Time stamp;
  std::string child_frame;  ///< empty where it was not offered
  bool gone = false;        ///< a further look did not bear it out
};

struct Answer {
  std::vector<planar_bin_picking::PartPtr> parts;  ///< that were looked for
  Frame frame;                                     ///< keeps the data of `grey` alive
  cv::Mat grey;
  planar_bin_picking::Camera camera;
  planar_bin_picking::LocateResult result;
  std_msgs::Header header;                               ///< stamp of the image, target frame
  std::vector<planar_bin_picking::LocatedPart> located;  ///< best first
  /// Failed picks are remembered by it: the surroundings look different from elsewhere.
  std::optional<FirstPicture> first = {};
  /// What is not offered, and what of the result it was, in the same order.
  std::vector<planar_bin_picking::RefusedPart> refused = {};
  std::vector<planar_bin_picking::Detection> refused_detections = {};
  Eigen::Isometry3d T_target_camera = Eigen::Isometry3d::Identity();  ///< at the image's stamp
  double tool_radius = 0.0;  ///< metres, where a part's file names no other
  std::vector<planar_bin_picking::ToolBody> tool_bodies = {};
  /// Of bin and region, camera frame: they are drawn into the picture.
  std::vector<std::vector<Eigen::Vector3d>> outlines = {};
  /// Of an answer to RefinePart, one for each of `parts`: what it takes the place of. Whatever else
  /// was answered before stays as it is.
  std::optional<std::vector<FormerPart>> former = {};
};

}  // namespace planar_bin_picking_ros
