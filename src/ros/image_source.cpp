// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image_source.h"

#include "names.h"
#include "refusal.h"

#include <planar_bin_picking/LocatePart.h>

#include <cstdio>

namespace planar_bin_picking_ros {

using Status = planar_bin_picking::LocatePart::Response;

namespace {

std::string seconds(const double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", value);
  return text;
}

/// An image from the future fits every wish, also one that was taken before the robot stood still.
void checkClock(const Frame& frame) {
  constexpr double kLargestLead = 0.1;  // s; clocks that are synchronized at all are closer
  const double lead = (frame.image->header.stamp - ros::Time::now()).toSec();
  // Simulated time comes in steps, and images may well be ahead of the last one.
  if (ros::Time::isSimTime() || lead <= kLargestLead) return;
  throw Refusal(Status::BAD_IMAGE,
                "image: its stamp lies " + seconds(lead) +
                    " in the future; synchronize the clocks of camera and computer");
}

}  // namespace

ImageSource::ImageSource(const ros::NodeHandle& nh, const ros::NodeHandle& pnh)
    : images_(nh),
      camera_(images_.subscribeCamera(
          kImageTopic, 1, &ImageInbox::push, &inbox_,
          image_transport::TransportHints("raw", ros::TransportHints(), pnh))) {}

Frame ImageSource::await(const ros::Time& not_before, const ros::Duration& timeout) {
  const SteadyTime now = std::chrono::steady_clock::now();
  FrameWish wish{not_before, SteadyTime{}};
  if (not_before.isZero()) wish = {ros::Time::now(), now};
  const auto frame = inbox_.wait(wish, now + std::chrono::nanoseconds(timeout.toNSec()));
  if (!frame && inbox_.closed()) {
    throw Refusal(Status::NO_IMAGE, "the node shut down while waiting; call again once it is back");
  }
  if (!frame) {
    throw Refusal(Status::NO_IMAGE, "no image that is new enough within " +
                                        seconds(timeout.toSec()) + ": " + whyNone(wish.not_before));
  }
  checkClock(*frame);
  return *frame;
}

std::string ImageSource::whyNone(const ros::Time& not_before) const {
  const std::string topic = camera_.getTopic();
  if (ros::Time::isSimTime() && ros::Time::now().isZero()) {
    return "use_sim_time is set, but no /clock comes in; start the bag or the simulator, or unset "
           "it";
  }
  const auto newest = inbox_.newest();
  if (newest) {
    const double age = (not_before - newest->image->header.stamp).toSec();
    return "of " + std::to_string(inbox_.count()) + " images on " + topic +
           " the newest was taken " + seconds(age) +
           " too early; check that the camera runs, its trigger, and that its clock and this one "
           "agree";
  }
  if (camera_.getNumPublishers() == 0) {
    return "nobody publishes " + topic + "; start the camera's driver or remap the topic";
  }
  return topic + " has a publisher, but no image came with a camera_info of the same stamp on " +
         camera_.getInfoTopic() + "; check both with rostopic hz";
}

}  // namespace planar_bin_picking_ros
