// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Where a cell's frames stand at an image's stamp: the camera, the answers' frame, bin and plane.

#include "locator/settings/cell_params.h"
#include "locator/pick_keeper.h"
#include "planar_bin_picking/locate/locate_request.h"
#include "shared/transforms.h"

#include <std_msgs/Header.h>

#include <Eigen/Geometry>

#include <string>

namespace planar_bin_picking_ros {

class CellFrames {
 public:
  /// Both have to outlive it.
  CellFrames(const CellParams& cell, const TransformBuffer& buffer)
      : cell_(cell), buffer_(buffer) {}

  /// @throws Refusal  NO_TRANSFORM
  Eigen::Isometry3d transform(const std::string& target, const std::string& source,
                              const ros::Time& stamp) const;

  /// Distances and plane of a call, without parts; max_parts is 0, since the pick policy cuts,
  /// after it has taken out what it refuses.
  /// @param image  its header
  planar_bin_picking::LocateRequest request(const std_msgs::Header& image) const;

  /// @param answer  stamp of the image, target frame
  PickKeeper::Frames pickFrames(const std_msgs::Header& answer,
                                const Eigen::Isometry3d& T_target_camera) const;

 private:
  const CellParams& cell_;
  const TransformBuffer& buffer_;
};

}  // namespace planar_bin_picking_ros
