// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/bin/bin_finder.h"

#include "shared/convert.h"
#include "shared/convert_camera.h"
#include "shared/names.h"
#include "shared/refusal.h"

#include <geometry_msgs/PoseStamped.h>
#include <ros/console.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::BinSearch;
using planar_bin_picking::FoundBin;

namespace {

constexpr double kDegrees = M_PI / 180.0;
constexpr double kLongestWait = 3600.0;  // s, as LocatePart's

/// What is kept is rounded, by hand perhaps to four digits: a bin that was believed just within the
/// limits must not stop the next start.
constexpr double kRoundedMetres = 1e-4, kRoundedDegrees = 0.02;

/// What an operator has to know of a change.
constexpr char kKeep[] = "; ~save_parameters keeps that beyond a restart";

std::string describe(const FoundBin& found) {
  char text[120];
  std::snprintf(text, sizeof text,
                "the bin stands %.1f mm from where bin_frame is, turned by %.2f and tilted by "
                "%.2f degrees",
                1e3 * found.moved, found.turned_deg, found.tilted_deg);
  return text;
}

}  // namespace

BinFinder::BinFinder(Host host, const ros::NodeHandle& call_pnh) : host_(std::move(host)) {
  ros::NodeHandle pnh(call_pnh);
  constexpr bool kLatch = true;
  topic_ = pnh.advertise<geometry_msgs::PoseStamped>(kBinTopic, 1, kLatch);
  begin();
  service_ = pnh.advertiseService(kLocateBinService, &BinFinder::serve, this);
}

void BinFinder::begin() {
  const Settings settings = host_.settings();
  if (settings.T_told_found.matrix() == Eigen::Matrix4d::Identity()) return;
  BinSearch limits = settings.search;
  limits.moved_max += kRoundedMetres;
  limits.turned_max_deg += kRoundedDegrees;
  limits.tilted_max_deg += kRoundedDegrees;
  const FoundBin found = planar_bin_picking::foundAt(limits, settings.T_told_found);
  if (!found.is_within) {
    throw std::invalid_argument("~cell/bin_found: " + describe(found) +
                                ", and bin_moved_max, bin_turned_max_deg and bin_tilted_max_deg "
                                "allow less: delete it, and find the bin anew with ~locate_bin");
  }
  ROS_WARN_STREAM("~cell/bin_found: "
                  << describe(found) << ". Where it has been put back since, call ~"
                  << kLocateBinService << " with forget: true, and ~" << kSaveParametersService);
  geometry_msgs::PoseStamped bin;
  bin.header.frame_id = settings.bin_frame;
  bin.header.stamp = ros::Time::now();
  bin.pose = toPoseMsg(settings.T_told_found);
  topic_.publish(bin);
}

bool BinFinder::serve(Request& request, Response& response) {
  response.bin.pose.orientation.w = 1.0;
  try {
    answer(request, &response);
  } catch (const Refusal& refusal) {
    response.status = refusal.status();
    response.message = refusal.what();
  } catch (const std::exception& error) {
    response.status = Response::INTERNAL_ERROR;
    response.message = std::string(error.what()) + "; please report this with the image";
  }
  ROS_INFO_STREAM(kLocateBinService << ": " << response.message);
  return true;  // the call itself worked, whatever its status
}

std::optional<FoundBin> BinFinder::find(const Frame& frame, const Settings& settings) {
  const std_msgs::Header& image = frame.image->header;
  BinSearch search = settings.search;
  search.told.T_camera_bin = host_.transform(image.frame_id, settings.bin_frame, image.stamp);
  const planar_bin_picking::Camera camera = host_.camera_of(frame);
  const std::lock_guard<std::mutex> lock(*host_.locate_mutex);
  try {
    return planar_bin_picking::findBin(toGrey(frame.image), camera, search, host_.locator());
  } catch (const std::invalid_argument& error) {  // size and distances
    throw Refusal(Response::BAD_BIN, std::string(error.what()) +
                                         "; the whole rim has to be in the picture: check "
                                         "~cell/bin_frame, bin_min, bin_max and bin_wall");
  }
}

void BinFinder::answer(const Request& request, Response* response) {
  const Settings settings = host_.settings();
  if (settings.bin_frame.empty() || settings.search.wall <= 0.0)
    throw Refusal(Response::NOT_SET,
                  "the cell names no bin with a rim: set ~cell/bin_frame, bin_min, bin_max and "
                  "bin_wall");
  const double timeout = request.timeout.toSec();
  if (!(timeout >= 0.0 && timeout <= kLongestWait))
    throw Refusal(Response::BAD_REQUEST, "timeout is " + std::to_string(timeout) +
                                             " s; give 0 for the cell's image_timeout, or up to "
                                             "an hour");
  if (request.forget) {
    host_.use(Eigen::Isometry3d::Identity());
    topic_.publish(geometry_msgs::PoseStamped());  // the one before no longer holds
    response->message = "the bin stands where bin_frame is" + std::string(kKeep);
    return;
  }
  const Frame frame = host_.await(request.not_before, request.timeout);
  const std_msgs::Header& image = frame.image->header;
  const auto found = find(frame, settings);
  if (!found)
    throw Refusal(Response::NOT_FOUND,
                  "no rim is seen: the whole rim has to be in the picture, and its size has to be "
                  "that of ~cell/bin_min, bin_max and bin_wall");
  response->bin.header.stamp = image.stamp;
  response->bin.header.frame_id =
      settings.target_frame.empty() ? image.frame_id : settings.target_frame;
  response->bin.pose =
      toPoseMsg(host_.transform(response->bin.header.frame_id, settings.bin_frame, image.stamp) *
                found->T_told_found);
  response->moved = found->moved;
  response->turned = found->turned_deg * kDegrees;
  response->tilted = found->tilted_deg * kDegrees;
  response->score = found->score;
  response->message = describe(*found);
  if (!found->is_within) {
    response->status = Response::TOO_FAR;
    response->message +=
        "; that is more than ~cell/bin_moved_max, bin_turned_max_deg or bin_tilted_max_deg allow: "
        "put it back, or correct the file";
    return;
  }
  response->status = Response::OK;
  if (!request.use) return;
  host_.use(found->T_told_found);
  topic_.publish(response->bin);
  response->message += "; that is where it is from now on" + std::string(kKeep);
}

}  // namespace planar_bin_picking_ros
