// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Publishes the latest answer: tf frames, the latched list and markers, and the overlay image,
/// which is drawn only for those who look at it, also when they come after the call, and never
/// while a caller waits.

#include "locator/answer/answer.h"
#include "locator/answer/part_frames.h"
#include "shared/clock_watch.h"

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <ros/wall_timer.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

class AnswerPublisher {
 public:
  /// @param pnh        its callback queue draws the overlay
  /// @param prompt_nh  its callback queue sends the frames; nothing on it may take long
  /// @param frame_prefix  "" = what tells this node's frames from another's
  AnswerPublisher(const ros::NodeHandle& pnh, const ros::NodeHandle& prompt_nh,
                  const std::string& frame_prefix);
  /// Withdraws all frames.
  ~AnswerPublisher();
  AnswerPublisher(const AnswerPublisher&) = delete;
  AnswerPublisher& operator=(const AnswerPublisher&) = delete;

  /// A call begins that will say anew where these parts are: what was said before no longer holds.
  void withdraw(const std::vector<planar_bin_picking::PartPtr>& parts);

  /// A call ended without an answer: rviz shall not go on showing the one before.
  void clearMarkers();

  /// Names the answer's frames and publishes it, in place of all answers about its parts, or of the
  /// former parts that it names. Safe to call from several threads.
  std::shared_ptr<const Answer> publish(Answer answer);

 private:
  class Draw;  ///< a callback that publishes the overlay

  /// Null while there is no answer.
  sensor_msgs::ImageConstPtr overlayOfLatest();

  /// These and what is due now. Under mutex_.
  void sendFrames(PartFrames::Transforms transforms = {});
  /// What an answer takes the place of is no longer shown. Under mutex_.
  void withdrawBefore(const Answer& answer);

  /// Keeps the frames' names for the next process of this node. Under mutex_.
  void remember();

  ros::NodeHandle pnh_;
  image_transport::ImageTransport images_;

  std::mutex mutex_;  ///< guards the state and the order of what is sent
  PartFrames frames_;
  ClockWatch clock_;
  std::string remembered_key_;
  std::size_t remembered_ = 0;
  std::shared_ptr<const Answer> latest_;
  std::vector<planar_bin_picking::LocatedPart> listed_;    ///< the latest list
  std::vector<planar_bin_picking::PartPtr> listed_kinds_;  ///< what it was taken from
  tf2_ros::TransformBroadcaster tf_;
  ros::Publisher list_, markers_;

  std::mutex overlay_mutex_;  ///< guards these two; taken before mutex_
  std::shared_ptr<const Answer> drawn_;
  sensor_msgs::ImageConstPtr picture_;
  image_transport::Publisher overlay_;
  ros::WallTimer timer_;
};

}  // namespace planar_bin_picking_ros
