// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A robot that stands still and has told where, on tf as long as this lives. Nothing is sent after
/// that: the robot may be anywhere then, and a look-up at a later time has to fail.

#include <tf2_ros/transform_broadcaster.h>

#include <Eigen/Geometry>

#include <atomic>
#include <string>
#include <thread>

namespace planar_bin_picking_ros {

class FlangeOnTf {
 public:
  /// @param tf  one that listeners had time to connect to
  FlangeOnTf(tf2_ros::TransformBroadcaster& tf, const std::string& base, const std::string& flange,
             const Eigen::Isometry3d& T_base_flange);
  ~FlangeOnTf();
  FlangeOnTf(const FlangeOnTf&) = delete;
  FlangeOnTf& operator=(const FlangeOnTf&) = delete;

 private:
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace planar_bin_picking_ros
