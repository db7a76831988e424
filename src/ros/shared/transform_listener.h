// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/clock_watch.h"
#include "shared/transforms.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2_msgs/TFMessage.h>

namespace planar_bin_picking_ros {

/// Fills a buffer from /tf and /tf_static in a thread of its own. When ROS time was set back, it
/// forgets what it had, static transforms aside.
class TransformListener {
 public:
  explicit TransformListener(TransformBuffer& buffer);
  ~TransformListener() { spinner_.stop(); }
  TransformListener(const TransformListener&) = delete;
  TransformListener& operator=(const TransformListener&) = delete;

 private:
  void take(const tf2_msgs::TFMessage& message, bool is_static);

  TransformBuffer& buffer_;
  ClockWatch clock_;
  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  ros::Subscriber tf_, tf_static_;
  ros::AsyncSpinner spinner_;
};

}  // namespace planar_bin_picking_ros
