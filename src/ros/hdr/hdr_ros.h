// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The HDR node: on request it takes an exposure bracket through the camera's driver and publishes
/// one 8-bit image of it, as a camera would. Where the bracket fails, the single exposure goes on,
/// and the caller is told why. The robot stands still meanwhile; the image's stamp is that of the
/// bracket's first frame.

#include "hdr/bracket.h"
#include "hdr/exposure_control.h"

#include <image_transport/camera_publisher.h>
#include <image_transport/camera_subscriber.h>
#include <image_transport/image_transport.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>

#include <string>

namespace planar_bin_picking_ros {

class HdrRos {
 public:
  /// @throws std::invalid_argument  a parameter is wrong: which one and why
  HdrRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);
  ~HdrRos();
  HdrRos(const HdrRos&) = delete;
  HdrRos& operator=(const HdrRos&) = delete;

 private:
  bool serve(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  /// @return  what was done. @throws std::exception  why there is no merged image
  std::string takeAndPublish();
  /// Asks a camera that does not run freely for a frame. @throws std::runtime_error  nobody answers
  void ask();
  void publish(const cv::Mat& grey, const ExposedFrame& first);

  const HdrNodeParams params_;
  ros::CallbackQueue image_queue_, call_queue_;
  ros::NodeHandle image_nh_, call_pnh_;
  ImageInbox inbox_;
  ExposureControl control_;
  BracketTaker taker_;
  image_transport::ImageTransport images_in_, images_out_;
  image_transport::CameraSubscriber camera_;
  image_transport::CameraPublisher merged_;
  ros::ServiceServer service_;
  ros::AsyncSpinner image_spinner_, call_spinner_;
};

}  // namespace planar_bin_picking_ros
