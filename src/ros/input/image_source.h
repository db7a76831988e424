// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The camera as a call sees it: one image that is new enough, or the reason why there is none.
/// Always subscribed, since a robot may ask for an image that has already come; an image that
/// nobody waits for costs a pointer.

#include "input/arrivals.h"
#include "input/image_inbox.h"
#include "shared/clock_watch.h"

#include <image_transport/image_transport.h>
#include <image_transport/subscriber_filter.h>
#include <message_filters/subscriber.h>
#include <message_filters/time_synchronizer.h>
#include <ros/duration.h>
#include <ros/node_handle.h>

#include <optional>
#include <string>

namespace planar_bin_picking_ros {

class ImageSource {
 public:
  /// @param nh   its callback queue must be served while calls wait
  /// @param pnh  where `~image_transport` may say how images come, such as `compressed`
  /// @param topic  "" = the camera's own; another one for a second camera
  ImageSource(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, const std::string& topic = "");

  /// @param not_before      oldest stamp; zero = taken and received from now on
  /// @param timeout         wall time
  /// @param received_after  when the image was asked for; nothing: it comes of itself
  /// @throws Refusal  NO_IMAGE, or BAD_IMAGE where the camera's clock is ahead
  Frame await(const ros::Time& not_before, const ros::Duration& timeout,
              const std::optional<SteadyTime>& received_after = std::nullopt);

  std::string topic() const { return images_.getTopic(); }
  void close() { inbox_.close(); }  ///< ends all waiting
  void open() { inbox_.open(); }    ///< after close(): later calls wait again

  struct Traffic {
    Arrivals images, infos;
    bool has_publisher = false;  ///< of images
  };
  Traffic traffic() const;
  /// The newest image with its camera_info.
  std::optional<Frame> newest() const { return inbox_.newest(); }
  /// Why the latest image has none; "" where all seems well.
  /// @pre  an image has come
  std::string whyNoPair() const;

 private:
  void note(const ros::Time& stamp, Arrivals* arrivals);
  void forgetIfClockWentBack();
  /// @param called  when the call began
  std::string whyNone(const FrameWish& wish, SteadyTime called) const;
  std::string whyNoPair(SteadyTime called) const;

  ImageInbox inbox_;
  ClockWatch clock_;
  mutable std::mutex arrivals_mutex_;
  Arrivals image_arrivals_, info_arrivals_;
  image_transport::ImageTransport transport_;
  image_transport::SubscriberFilter images_;
  message_filters::Subscriber<sensor_msgs::CameraInfo> infos_;
  message_filters::TimeSynchronizer<sensor_msgs::Image, sensor_msgs::CameraInfo> pairs_;
};

}  // namespace planar_bin_picking_ros
