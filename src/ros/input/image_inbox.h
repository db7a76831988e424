// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Where the camera's callback leaves images and where calls wait for them. Holds the newest image
/// alone, as it came: nothing is copied or converted until a call wants it. Any number of threads.

#include <ros/time.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>

namespace planar_bin_picking_ros {

using SteadyTime = std::chrono::steady_clock::time_point;

struct Frame {
  sensor_msgs::ImageConstPtr image;
  sensor_msgs::CameraInfoConstPtr info;
  SteadyTime received;   ///< when it came in
  ros::Time clock = {};  ///< what ROS time it was then
};

/// The image that a call accepts. All limits hold: a stamp alone could lie (a bag that starts over,
/// a camera whose clock is ahead), the moment of reception alone could accept an image that was
/// long under way.
struct FrameWish {
  ros::Time not_before;       ///< oldest stamp
  SteadyTime received_after;  ///< default: whenever it came
  ros::Time clock_from = {};  ///< ROS time of its reception, at least
};

class ImageInbox {
 public:
  void push(const sensor_msgs::ImageConstPtr& image, const sensor_msgs::CameraInfoConstPtr& info);

  /// Waits for an image that fits the wish. The deadline is steady time, since ROS time may stand
  /// still (a paused bag) and the caller must get an answer all the same.
  /// @return  nothing at the deadline or once closed
  std::optional<Frame> wait(const FrameWish& wish, SteadyTime deadline);

  std::size_t count() const;  ///< images so far
  std::optional<Frame> newest() const;
  void forget();  ///< the newest image: no call gets it any more

  /// Ends all waiting, now and later.
  void close();
  bool closed() const;
  void open();  ///< later calls wait again

 private:
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::optional<Frame> newest_;
  std::size_t count_ = 0;
  bool closed_ = false;
};

}  // namespace planar_bin_picking_ros
