// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/region/region_keeper.h"

#include "locator/answer/scene_markers.h"
#include "shared/names.h"

#include <ros/console.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::RegionFile;
using planar_bin_picking::regionOutline;

namespace {

constexpr int kPointsQueue = 100;
constexpr std::size_t kPointsMost = 100;  // corners; somebody clicks without end

/// @return  whether points make an outline; else why not, in `why`
bool isOutline(const planar_bin_picking::RegionOutline& points, std::string* why) {
  try {
    regionOutline(points);
    return true;
  } catch (const std::invalid_argument& error) {
    *why = error.what();
    return false;
  }
}

}  // namespace

RegionKeeper::RegionKeeper(Settings settings, const TransformBuffer& buffer,
                           const ros::NodeHandle& prompt_nh, const ros::NodeHandle& prompt_pnh,
                           ScenePublisher& scene)
    : settings_(std::move(settings)), buffer_(buffer), scene_(scene) {
  region_ = {regionOutline(settings_.region_px), regionOutline(settings_.region)};
  if (!settings_.file.empty()) {
    if (const auto taught = planar_bin_picking::loadRegion(settings_.file)) {
      if (taught->frame != settings_.frame) {
        throw std::runtime_error(settings_.file + ": its region is in frame " + taught->frame +
                                 ", the cell's in " + settings_.frame +
                                 "; teach it again, or correct ~cell/region_frame");
      }
      region_.metres = taught->metres;
    }
  }
  ros::NodeHandle nh(prompt_nh), pnh(prompt_pnh);
  points_in_ = nh.subscribe(kClickedPointTopic, kPointsQueue, &RegionKeeper::take, this);
  save_service_ = pnh.advertiseService(kSaveRegionService, &RegionKeeper::save, this);
  clear_service_ = pnh.advertiseService(kClearRegionService, &RegionKeeper::clear, this);
  show();
}

planar_bin_picking::Region RegionKeeper::current() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return region_;
}

void RegionKeeper::take(const geometry_msgs::PointStamped& point) {
  if (settings_.frame.empty()) return;  // no region can be told: save says so
  const Eigen::Vector3d p(point.point.x, point.point.y, point.point.z);
  if (!p.allFinite()) {
    ROS_WARN_STREAM("region: a point of " << kClickedPointTopic << " is no number; passed over");
    return;
  }
  const LookupResult found =
      point.header.frame_id == settings_.frame
          ? LookupResult{Eigen::Isometry3d::Identity(), ""}
          : lookup(buffer_, settings_.frame, point.header.frame_id, point.header.stamp,
                   std::chrono::duration<double>(settings_.tf_timeout));
  if (!found.T_target_source) {
    ROS_WARN_STREAM("region: no transform from " << point.header.frame_id << " to "
                                                 << settings_.frame << ": " << found.reason
                                                 << "; the point is passed over");
    return;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (points_.size() >= kPointsMost) {
    ROS_WARN_STREAM("region: has " << kPointsMost << " corners; call ~" << kClearRegionService);
    return;
  }
  points_.push_back((*found.T_target_source * p).head<2>());
  ROS_INFO_STREAM("region: corner " << points_.size() << "; ~" << kSaveRegionService
                                    << " puts it in force from the third on");
  show();
}

bool RegionKeeper::save(Request&, Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string why;
  response.success = false;
  if (settings_.frame.empty() || settings_.file.empty()) {
    response.message =
        "set ~cell/region_file, and ~cell/region_frame where neither bin nor "
        "target_frame names one: where a region is kept, and in which frame";
  } else if (points_.empty()) {
    response.message = "no point was clicked: publish three or more with rviz's tool Publish Point";
  } else if (!isOutline(points_, &why)) {
    response.message =
        "the region " + why + "; click more corners, or ~clear_region and begin anew";
  } else {
    try {
      planar_bin_picking::saveRegion(settings_.file, RegionFile{settings_.frame, points_});
      region_.metres = std::move(points_);
      points_.clear();
      response.success = true;
      response.message = "a region of " + std::to_string(region_.metres.size()) +
                         " corners is in force and stands in " + settings_.file;
    } catch (const std::runtime_error& error) {
      response.message = error.what();
    }
  }
  ROS_INFO_STREAM(kSaveRegionService << ": " << response.message);
  show();
  return true;
}

bool RegionKeeper::clear(Request&, Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  response.success = true;
  if (!points_.empty()) {
    response.message = std::to_string(points_.size()) + " points are forgotten";
    points_.clear();
  } else {
    std::error_code error;
    std::filesystem::remove(settings_.file, error);  // that it is not there is no error
    region_.metres = regionOutline(settings_.region);
    response.message = region_.metres.empty() ? "there is no region in metres any more"
                                              : "the cell's own region is in force";
    if (error) {  // it would be back at the next start
      response.success = false;
      response.message += ", but " + settings_.file + " cannot be deleted: " + error.message();
    }
  }
  ROS_INFO_STREAM(kClearRegionService << ": " << response.message);
  show();
  return true;
}

void RegionKeeper::show() {
  std::string why;
  const bool good = points_.empty() || isOutline(points_, &why);
  scene_.show("region", regionMarkers(settings_.frame, region_.metres, points_, good));
}

}  // namespace planar_bin_picking_ros
