// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Publishes the latest answer: tf frames, the latched list and markers, and the overlay image, which
/// is drawn only for those who look at it, also when they come after the call.

#include "answer.h"
#include "part_frames.h"

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <memory>
#include <mutex>
#include <string>

namespace planar_bin_picking_ros {

class AnswerPublisher {
 public:
  /// @param pnh  its callback queue draws the overlay for those who subscribe later
  AnswerPublisher(const ros::NodeHandle& pnh, const std::string& frame_prefix);

  /// Names the answer's frames and publishes it. Safe to call from several threads.
  std::shared_ptr<const Answer> publish(Answer answer);

 private:
  void showLatest(const image_transport::SingleSubscriberPublisher& subscriber);
  /// Drawn at the first use. @pre mutex_ is held and there is an answer
  sensor_msgs::ImageConstPtr overlayOfLatest();

  ros::NodeHandle pnh_;
  image_transport::ImageTransport images_;
  std::mutex mutex_;  ///< guards all below
  PartFrames frames_;
  tf2_ros::StaticTransformBroadcaster tf_;
  std::shared_ptr<const Answer> latest_;
  sensor_msgs::ImageConstPtr latest_overlay_;
  ros::Publisher list_, markers_;
  image_transport::Publisher overlay_;
};

}  // namespace planar_bin_picking_ros
