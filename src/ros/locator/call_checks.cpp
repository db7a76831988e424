// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/call_checks.h"

#include "planar_bin_picking/locate/part_size.h"
#include "shared/refusal.h"

#include <ros/time.h>

#include <vector>

namespace planar_bin_picking_ros {

using planar_bin_picking::Camera;
using planar_bin_picking::FaceFilter;
using planar_bin_picking::LocatePart;
using planar_bin_picking::LocateRequest;
using planar_bin_picking::PartPtr;

namespace {

constexpr double kLongestWait = 3600.0;  ///< s; a call that waits longer has been forgotten
constexpr int kLeastPixels = 64;         ///< per side, as Locator::locate has it

}  // namespace

FaceFilter faceFilter(const std::uint8_t face) {
  using Request = planar_bin_picking::LocatePart::Request;
  switch (face) {
    case Request::ANY:
      return FaceFilter::kAny;
    case Request::FRONT:
      return FaceFilter::kFront;
    case Request::BACK:
      return FaceFilter::kBack;
  }
  throw Refusal(planar_bin_picking::LocatePart::Response::BAD_REQUEST,
                "face is " + std::to_string(face) + "; it must be ANY (0), FRONT (1) or BACK (2)");
}

void checkTimes(const LocatePart::Request& request) {
  const auto refuse = [](const std::string& text) {
    throw Refusal(LocatePart::Response::BAD_REQUEST, text);
  };
  if (request.timeout < ros::Duration(0))
    refuse("timeout is negative; zero means the cell's image_timeout");
  if (request.timeout.toSec() > kLongestWait)
    refuse("timeout is " + std::to_string(request.timeout.toSec()) + " s; an hour is the most");
  const ros::Time now = ros::Time::now();
  if (!now.isZero() && request.not_before.toSec() - now.toSec() > kLongestWait) {
    refuse("not_before lies " + std::to_string(request.not_before.toSec() - now.toSec()) +
           " s in the future; give the time at which the robot stood still, or zero for now");
  }
}

void checkSize(const sensor_msgs::Image& image) {
  if (image.width >= kLeastPixels && image.height >= kLeastPixels) return;
  throw Refusal(LocatePart::Response::BAD_IMAGE,
                "image: is " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                    " pixels, must have " + std::to_string(kLeastPixels) +
                    " each way; check the driver's region of interest");
}

std::string dropUnsuitable(const Camera& camera, LocateRequest* request) {
  std::string text;
  std::vector<PartPtr> suitable;
  for (const PartPtr& part : request->parts) {
    try {
      planar_bin_picking::checkPartSize(*part, camera, request->distance_min,
                                        request->distance_max);
      suitable.push_back(part);
    } catch (const planar_bin_picking::PartSizeError& error) {
      text += (text.empty() ? "" : "; ") + std::string(error.what());
    }
  }
  if (suitable.empty()) throw Refusal(LocatePart::Response::BAD_PART_SIZE, text);
  request->parts = suitable;
  return text;
}

}  // namespace planar_bin_picking_ros
