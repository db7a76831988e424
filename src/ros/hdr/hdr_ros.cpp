// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hdr/hdr_ros.h"

#include "shared/convert_camera.h"
#include "shared/names.h"
#include "shared/param_reader.h"
#include "shared/timed_call.h"

#include <cv_bridge/cv_bridge.h>
#include <ros/console.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

namespace planar_bin_picking_ros {

using planar_bin_picking::Exposure;

namespace {

ros::NodeHandle onQueue(ros::NodeHandle nh, ros::CallbackQueue* queue) {
  nh.setCallbackQueue(queue);
  return nh;
}

int threadsOr(const int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

HdrRos::HdrRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh)
    : params_(loadHdrNodeParams(readTree(pnh, kHdrParams))),
      image_nh_(onQueue(nh, &image_queue_)),
      call_pnh_(onQueue(pnh, &call_queue_)),
      control_(nh, params_),
      taker_(
          params_, [this](double seconds) { control_.set(seconds); }, [this] { ask(); }, &inbox_),
      images_in_(image_nh_),
      images_out_(pnh),
      camera_(images_in_.subscribeCamera(
          kImageTopic, 1, &ImageInbox::push, &inbox_,
          image_transport::TransportHints("raw", ros::TransportHints(), pnh))),
      merged_(images_out_.advertiseCamera(kHdrImageTopic, 1)),
      image_spinner_(1, &image_queue_),
      call_spinner_(1, &call_queue_) {
  ROS_INFO_STREAM("hdr:" << describe(params_));
  service_ = call_pnh_.advertiseService(kTakeService, &HdrRos::serve, this);
  image_spinner_.start();
  call_spinner_.start();
  ROS_INFO_STREAM("ready: frames from " << camera_.getTopic() << ", images on "
                                        << merged_.getTopic() << ", calls on "
                                        << service_.getService());
}

HdrRos::~HdrRos() {
  inbox_.close();  // before the spinner, which waits for a call that is being served
  service_.shutdown();
  call_spinner_.stop();
  image_spinner_.stop();
}

bool HdrRos::serve(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  try {
    response.message = takeAndPublish();
    response.success = true;
    ROS_INFO_STREAM("hdr: " << response.message);
  } catch (const std::exception& error) {
    response.message = error.what();
    response.success = false;
    ROS_ERROR_STREAM("hdr: " << response.message);
  }
  return true;  // the call itself worked, whatever came of it
}

std::string HdrRos::takeAndPublish() {
  const auto start = std::chrono::steady_clock::now();
  ExposedFrame single = taker_.takeSingle(0.0);
  std::vector<ExposedFrame> frames;
  try {
    single.seconds = control_.single();
    frames = taker_.take(single);
  } catch (const std::exception& error) {
    publish(toGrey(single.frame.image), single);
    throw std::runtime_error(std::string("the single exposure goes on: ") + error.what());
  }
  const auto taken = std::chrono::steady_clock::now();
  std::vector<Exposure> bracket;
  for (const ExposedFrame& exposed : frames)
    bracket.push_back({toGrey(exposed.frame.image), exposed.seconds});
  publish(planar_bin_picking::mergeExposures(bracket, params_.merge, threadsOr(params_.threads)),
          single);
  const auto merged = std::chrono::steady_clock::now();
  char text[120];
  std::snprintf(text, sizeof text, "%zu exposures taken in %.3f s, merged in %.3f s", frames.size(),
                std::chrono::duration<double>(taken - start).count(),
                std::chrono::duration<double>(merged - taken).count());
  return text;
}

void HdrRos::ask() {
  if (params_.trigger_service.empty()) return;
  std_srvs::Trigger service;
  const std::string name = image_nh_.resolveName(params_.trigger_service);
  const CallEnd end = callWithin(image_nh_, name, params_.command_timeout, &service);
  if (end == CallEnd::kAnswered && service.response.success) return;
  std::string reason = "nobody answers it";
  if (end == CallEnd::kFailed) reason = "the call failed; see the log of its node";
  if (end == CallEnd::kLate) reason = "no answer within ~hdr/command_timeout";
  if (end == CallEnd::kAnswered) reason = service.response.message;
  throw std::runtime_error(name + " makes no frame: " + reason);
}

void HdrRos::publish(const cv::Mat& grey, const ExposedFrame& first) {
  const std_msgs::Header& header = first.frame.image->header;
  const bool is_mono8 = grey.depth() == CV_8U;
  namespace enc = sensor_msgs::image_encodings;
  const auto image =
      cv_bridge::CvImage(header, is_mono8 ? enc::MONO8 : enc::MONO16, grey).toImageMsg();
  const auto info = boost::make_shared<sensor_msgs::CameraInfo>(*first.frame.info);
  info->header = header;
  merged_.publish(image, info);
}

}  // namespace planar_bin_picking_ros
