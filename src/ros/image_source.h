// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The camera as a call sees it: one image that is new enough, or the reason why there is none.
/// Always subscribed, since a robot may ask for an image that has already come; an image that
/// nobody waits for costs a pointer.

#include "image_inbox.h"

#include <image_transport/camera_subscriber.h>
#include <image_transport/image_transport.h>
#include <ros/duration.h>
#include <ros/node_handle.h>

#include <string>

namespace planar_bin_picking_ros {

class ImageSource {
 public:
  /// @param nh   its callback queue must be served while calls wait
  /// @param pnh  where `~image_transport` may say how images come, such as `compressed`
  ImageSource(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);

  /// @param not_before  oldest stamp; zero = taken and received from now on
  /// @param timeout     wall time
  /// @throws Refusal  NO_IMAGE, or BAD_IMAGE where the camera's clock is ahead
  Frame await(const ros::Time& not_before, const ros::Duration& timeout);

  std::string topic() const { return camera_.getTopic(); }
  void close() { inbox_.close(); }  ///< ends all waiting
  void open() { inbox_.open(); }    ///< after close(): later calls wait again

 private:
  std::string whyNone(const ros::Time& not_before) const;

  ImageInbox inbox_;
  image_transport::ImageTransport images_;
  image_transport::CameraSubscriber camera_;
};

}  // namespace planar_bin_picking_ros
