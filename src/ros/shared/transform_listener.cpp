// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/transform_listener.h"

#include <ros/console.h>

namespace planar_bin_picking_ros {

TransformListener::TransformListener(TransformBuffer& buffer)
    : buffer_(buffer), spinner_(1, &queue_) {
  constexpr int kQueue = 100;  // as tf2's own listener has it
  nh_.setCallbackQueue(&queue_);
  tf_ = nh_.subscribe<tf2_msgs::TFMessage>(
      "/tf", kQueue, [this](const tf2_msgs::TFMessageConstPtr& m) { take(*m, false); });
  tf_static_ = nh_.subscribe<tf2_msgs::TFMessage>(
      "/tf_static", kQueue, [this](const tf2_msgs::TFMessageConstPtr& m) { take(*m, true); });
  spinner_.start();
}

void TransformListener::take(const tf2_msgs::TFMessage& message, const bool is_static) {
  if (clock_.wentBack()) {
    ROS_WARN("ROS time was set back: what tf said before is forgotten");
    buffer_.clear();
  }
  for (const auto& transform : message.transforms)
    buffer_.setTransform(transform, is_static ? "/tf_static" : "/tf", is_static);
}

}  // namespace planar_bin_picking_ros
