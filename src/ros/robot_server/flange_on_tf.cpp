// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "robot_server/flange_on_tf.h"

#include "shared/convert.h"

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

namespace planar_bin_picking_ros {

FlangeOnTf::FlangeOnTf(tf2_ros::TransformBroadcaster& tf, const std::string& base,
                       const std::string& flange, const Eigen::Isometry3d& T_base_flange) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = base;
  transform.child_frame_id = flange;
  transform.transform = toTransformMsg(T_base_flange);
  thread_ = std::thread([this, &tf, transform]() mutable {
    constexpr double kRate = 50.0;  // Hz; far below tf_gap_max
    while (!ends_) {
      transform.header.stamp = ros::Time::now();
      tf.sendTransform(transform);
      ros::WallDuration(1.0 / kRate).sleep();
    }
  });
}

FlangeOnTf::~FlangeOnTf() {
  ends_ = true;
  thread_.join();
}

}  // namespace planar_bin_picking_ros
