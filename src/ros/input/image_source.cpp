// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "input/image_source.h"

#include "shared/names.h"
#include "shared/refusal.h"

#include <image_transport/camera_common.h>
#include <planar_bin_picking/LocatePart.h>

#include <cmath>
#include <cstdio>

namespace planar_bin_picking_ros {

using Status = planar_bin_picking::LocatePart::Response;

namespace {

constexpr std::uint32_t kImagesKept = 1, kInfosKept = 10, kPairsKept = 10;  // waiting for the other

std::string seconds(const double value) {
  constexpr double kMillisecond = 1e-3;  // two readings of one clock may be nearer
  const bool is_small = value > 0.0 && value < kMillisecond;
  char text[32];
  std::snprintf(text, sizeof text, is_small ? "%.3f ms" : "%.3f s",
                is_small ? value / kMillisecond : value);
  return text;
}

/// An image from the future fits every wish, also one that was taken before the robot stood still.
void checkClock(const Frame& frame) {
  constexpr double kLargestLead = 0.1;  // s; clocks that are synchronized at all are closer
  const double lead = between(frame.clock, frame.image->header.stamp);
  // Simulated time comes in steps, and images may well be ahead of the last one.
  if (ros::Time::isSimTime() || lead <= kLargestLead) return;
  throw Refusal(Status::BAD_IMAGE,
                "image: its stamp lies " + seconds(lead) +
                    " in the future; synchronize the clocks of camera and computer");
}

std::string zeroStamp(const std::string& topic) {
  return "images on " + topic +
         " have a stamp of zero, so that nobody knows when they were taken; let the driver fill in "
         "header.stamp";
}

std::string ago(const SteadyTime then) {
  return seconds(std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count()) +
         " ago";
}

}  // namespace

ImageSource::ImageSource(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                         const std::string& name)
    : transport_(nh), pairs_(kPairsKept) {
  // The sibling's name follows from the image's after remapping, as image_transport has it.
  const std::string topic = nh.resolveName(name.empty() ? kImageTopic : name);
  pairs_.connectInput(images_, infos_);
  // Else messages that wait with stamps of before a jump back would be kept, and all new ones lost.
  pairs_.setReset(true);
  pairs_.registerCallback(
      boost::bind(&ImageInbox::push, &inbox_, boost::placeholders::_1, boost::placeholders::_2));
  images_.registerCallback(boost::function<void(const sensor_msgs::ImageConstPtr&)>(
      [this](const auto& image) { note(image->header.stamp, &image_arrivals_); }));
  infos_.registerCallback(boost::function<void(const sensor_msgs::CameraInfoConstPtr&)>(
      [this](const auto& info) { note(info->header.stamp, &info_arrivals_); }));
  ros::NodeHandle info_nh(nh);
  infos_.subscribe(info_nh, image_transport::getCameraInfoTopic(topic), kInfosKept);
  images_.subscribe(transport_, topic, kImagesKept,
                    image_transport::TransportHints("raw", ros::TransportHints(), pnh));
}

void ImageSource::note(const ros::Time& stamp, Arrivals* arrivals) {
  forgetIfClockWentBack();
  const std::lock_guard<std::mutex> lock(arrivals_mutex_);
  arrivals->note(stamp, std::chrono::steady_clock::now());
}

void ImageSource::forgetIfClockWentBack() {
  if (clock_.wentBack()) inbox_.forget();
}

Frame ImageSource::await(const ros::Time& not_before, const ros::Duration& timeout,
                         const std::optional<SteadyTime>& received_after) {
  const SteadyTime now = std::chrono::steady_clock::now();
  forgetIfClockWentBack();
  FrameWish wish{not_before, received_after.value_or(SteadyTime{}), {}};
  if (not_before.isZero() && !received_after) wish = {ros::Time::now(), now, {}};
  // What came in before that moment was also taken before, whatever its stamp says. Simulated time
  // comes in steps: there a stamp may be ahead of the clock and right.
  if (!ros::Time::isSimTime()) wish.clock_from = wish.not_before;
  const auto frame = inbox_.wait(wish, now + std::chrono::nanoseconds(timeout.toNSec()));
  if (!frame && inbox_.closed()) {
    throw Refusal(Status::NO_IMAGE, "the node shut down while waiting; call again once it is back");
  }
  if (!frame) {
    throw Refusal(Status::NO_IMAGE, "no image that is new enough within " +
                                        seconds(timeout.toSec()) + ": " +
                                        whyNone(wish, received_after.value_or(now)));
  }
  checkClock(*frame);
  return *frame;
}

ImageSource::Traffic ImageSource::traffic() const {
  const bool has_publisher = images_.getNumPublishers() > 0;
  const std::lock_guard<std::mutex> lock(arrivals_mutex_);
  return {image_arrivals_, info_arrivals_, has_publisher};
}

std::string ImageSource::whyNone(const FrameWish& wish, const SteadyTime called) const {
  if (ros::Time::isSimTime() && ros::Time::now().isZero()) {
    return "use_sim_time is set, but no /clock comes in; start the bag or the simulator, or unset "
           "it";
  }
  const auto newest = inbox_.newest();
  if (!newest || newest->received < called) {
    const std::string why = whyNoPair(called);
    if (!why.empty()) return why;
  }
  if (!newest) return topic() + " and its camera_info come in pairs again only now; call again";
  if (newest->image->header.stamp.isZero()) return zeroStamp(topic());
  const double age = between(newest->image->header.stamp, wish.not_before);
  if (age > 0.0) {
    return "of " + std::to_string(inbox_.count()) + " images on " + topic() +
           " the newest was taken " + seconds(age) +
           " too early; check that the camera runs, its trigger, and that its clock and this one "
           "agree";
  }
  return "the newest of " + std::to_string(inbox_.count()) + " images on " + topic() +
         " came in before it was asked for, although its stamp is later; check the camera's "
         "trigger, and that its clock and this one agree";
}

std::string ImageSource::whyNoPair() const {
  // As of a call just before the latest image: its camera_info came a little before or after it.
  constexpr std::chrono::seconds kBefore(1);
  return whyNoPair(traffic().images.received() - kBefore);
}

std::string ImageSource::whyNoPair(const SteadyTime called) const {
  const std::string info_topic = infos_.getTopic();
  const std::lock_guard<std::mutex> lock(arrivals_mutex_);
  const Arrivals &image = image_arrivals_, &info = info_arrivals_;
  if (images_.getNumPublishers() == 0 && image.received() < called) {
    return "nobody publishes " + topic() + "; start the camera's driver or remap the topic";
  }
  if (image.count() == 0) {
    return topic() +
           " has a publisher, but no image has come yet; check the camera and its trigger";
  }
  if (image.received() < called) {
    return "no image came on " + topic() + " since the call, the last one " +
           ago(image.received()) + "; check that the camera runs, and its trigger";
  }
  if (image.stamp().isZero()) return zeroStamp(topic());
  if (info.count() == 0) {
    return "images come on " + topic() + ", but no camera_info on " + info_topic +
           "; let the driver publish it beside the images";
  }
  if (info.received() < called) {
    return "images come on " + topic() + ", but camera_info on " + info_topic +
           " stopped, the last one came " + ago(info.received()) + "; check the driver";
  }
  const double lead = image.lead(info, called);
  if (lead != 0.0) {
    return "no image has a camera_info of the same stamp: " + info_topic + " is " +
           seconds(std::abs(lead)) + (lead < 0.0 ? " older" : " newer") +
           " than the image that came with it on " + topic() +
           "; let the driver give both one stamp";
  }
  return "";
}

}  // namespace planar_bin_picking_ros
