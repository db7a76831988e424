// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Where a cell's frames stand at an image's stamp: the camera, the answers' frame, bin, region and
/// plane.

#include "locator/pick_keeper.h"
#include "locator/settings/cell_params.h"
#include "planar_bin_picking/locate/locate_request.h"
#include "shared/transforms.h"

#include <geometry_msgs/TransformStamped.h>
#include <std_msgs/Header.h>

#include <Eigen/Geometry>

#include <optional>
#include <string>

namespace planar_bin_picking_ros {

/// What one call needs to know.
struct Standing {
  PickKeeper::Frames pick;  ///< the answers' frame from the camera's, and the bin
  std::optional<Eigen::Isometry3d> T_camera_bin, T_camera_plane;  ///< where the cell names them
  /// Identity where the cell names no frame for a region.
  Eigen::Isometry3d T_region_camera = Eigen::Isometry3d::Identity();
};

class CellFrames {
 public:
  /// @param buffer  has to outlive it
  CellFrames(const TransformBuffer& buffer, double tf_timeout)
      : tf_timeout_(tf_timeout), buffer_(buffer) {}

  /// @throws Refusal  NO_TRANSFORM
  Eigen::Isometry3d transform(const std::string& target, const std::string& source,
                              const ros::Time& stamp) const;

  /// @param cell    as it is for this call
  /// @param image   its header
  /// @param target  frame of the answers
  /// @param flange  where it stands, in place of tf; without a child_frame_id tf says it
  /// @throws Refusal  NO_TRANSFORM
  Standing at(const CellParams& cell, const std_msgs::Header& image, const std::string& target,
              const geometry_msgs::TransformStamped& flange = {}) const;

  /// Distances and plane of a call, without parts; max_parts is 0, since the pick policy cuts,
  /// after it has taken out what it refuses.
  /// @throws Refusal  BAD_BIN, BAD_PLANE
  planar_bin_picking::LocateRequest request(const CellParams& cell, const Standing& standing) const;

 private:
  const double tf_timeout_;
  const TransformBuffer& buffer_;
};

/// @throws Refusal  BAD_REQUEST: it names one of its frames only, or is no pose
void checkFlange(const geometry_msgs::TransformStamped& flange);

}  // namespace planar_bin_picking_ros
