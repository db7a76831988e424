// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Publishes the latest answer: tf frames, the latched list and markers, and the overlay image,
/// which is drawn only for those who look at it, also when they come after the call, and never
/// while a caller waits.

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
  /// @param pnh  its callback queue draws the overlay
  AnswerPublisher(const ros::NodeHandle& pnh, const std::string& frame_prefix);
  ~AnswerPublisher();
  AnswerPublisher(const AnswerPublisher&) = delete;
  AnswerPublisher& operator=(const AnswerPublisher&) = delete;

  /// Names the answer's frames and publishes it. Safe to call from several threads.
  std::shared_ptr<const Answer> publish(Answer answer);

 private:
  class Draw;  ///< a callback that publishes the overlay

  /// Null while there is no answer.
  sensor_msgs::ImageConstPtr overlayOfLatest();

  ros::NodeHandle pnh_;
  image_transport::ImageTransport images_;

  std::mutex mutex_;  ///< guards the state and the order of what is sent
  PartFrames frames_;
  std::shared_ptr<const Answer> latest_;
  tf2_ros::StaticTransformBroadcaster tf_;
  ros::Publisher list_, markers_;

  std::mutex overlay_mutex_;  ///< guards these two; taken before mutex_
  std::shared_ptr<const Answer> drawn_;
  sensor_msgs::ImageConstPtr picture_;
  image_transport::Publisher overlay_;
};

}  // namespace planar_bin_picking_ros
