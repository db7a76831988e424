// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "input/image_source.h"
#include "planar_bin_picking/image/camera.h"

#include <ros/duration.h>
#include <ros/time.h>

#include <Eigen/Geometry>

#include <functional>
#include <mutex>
#include <string>

namespace planar_bin_picking_ros {

/// What a service that takes pictures of its own needs of the locator.
struct PictureHost {
  std::function<Frame(const ros::Time& not_before, const ros::Duration& timeout)> await;
  std::function<planar_bin_picking::Camera(const Frame& frame)> camera_of;
  std::function<Eigen::Isometry3d(const std::string& target, const std::string& source,
                                  const ros::Time& stamp)>
      transform;
  std::mutex* locate_mutex;
};

}  // namespace planar_bin_picking_ros
