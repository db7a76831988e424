// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/region/region_keeper.h"

#include "locator/answer/scene_markers.h"
#include "shared/names.h"

#include <ros/console.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::RegionFile;
using planar_bin_picking::regionOutline;
using planar_bin_picking::RegionOutline;

namespace {

constexpr int kPointsQueue = 100;
constexpr double kStill = 1e-4;           // metres: less than a hand can mean
constexpr std::size_t kPointsMost = 100;  // corners; somebody clicks without end

/// @return  whether points make an outline; else why not, in `why`
bool isOutline(const RegionOutline& points, std::string* why) {
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
    : settings_(std::move(settings)),
      buffer_(buffer),
      scene_(scene),
      handles_(prompt_pnh, settings_.frame, actions()) {
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
  points_.push_back((settings_.T_frame_region().inverse() * *found.T_target_source * p).head<2>());
  ROS_INFO_STREAM("region: corner " << points_.size() << "; ~" << kSaveRegionService
                                    << " puts it in force from the third on");
  show();
}

void RegionKeeper::redraw() {
  const std::lock_guard<std::mutex> lock(mutex_);
  show();
}

const RegionOutline& RegionKeeper::corners() const {
  if (!points_.empty()) return points_;
  return region_.metres.empty() ? settings_.floor : region_.metres;
}

void RegionKeeper::change(const std::size_t corner, const std::function<void(RegionOutline*)>& edit,
                          const bool with_handles) {
  const std::lock_guard<std::mutex> lock(mutex_);
  RegionOutline edited = corners();
  if (corner >= edited.size()) return;
  edit(&edited);
  points_ = std::move(edited);
  show(with_handles);
}

bool RegionKeeper::isStill(const std::size_t corner, const Eigen::Vector2d& place) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const RegionOutline& now = corners();
  return points_.empty() && corner < now.size() && (place - now[corner]).norm() < kStill;
}

RegionHandles::Actions RegionKeeper::actions() {
  RegionHandles::Actions actions;
  actions.move = [this](const std::size_t corner, const Eigen::Vector3d& place, bool is_end) {
    const Eigen::Vector3d there = settings_.T_frame_region().inverse() * place;
    if (isStill(corner, there.head<2>())) return;
    // A handle that is sent anew would be taken out of the hand that drags it.
    change(
        corner, [&](RegionOutline* corners) { (*corners)[corner] = there.head<2>(); }, is_end);
  };
  actions.insert = [this](const std::size_t corner) {
    change(corner, [&](RegionOutline* corners) {
      if (corners->size() >= kPointsMost) return;
      const Eigen::Vector2d next = (*corners)[(corner + 1) % corners->size()];
      const Eigen::Vector2d middle = 0.5 * ((*corners)[corner] + next);
      corners->insert(corners->begin() + static_cast<std::ptrdiff_t>(corner) + 1, middle);
    });
  };
  actions.remove = [this](const std::size_t corner) {
    constexpr std::size_t kFewest = 3;
    change(corner, [&](RegionOutline* corners) {
      if (corners->size() > kFewest)
        corners->erase(corners->begin() + static_cast<std::ptrdiff_t>(corner));
    });
  };
  actions.save = [this] {
    bool is_saved = false;
    const std::string text = saveTaught(&is_saved);
    if (is_saved) {
      ROS_INFO_STREAM("region: " << text);
    } else {
      ROS_WARN_STREAM("region: " << text);
    }
  };
  actions.clear = [this] {
    const std::lock_guard<std::mutex> lock(mutex_);
    points_.clear();
    show();
  };
  return actions;
}

std::string RegionKeeper::saveTaught(bool* is_saved) {
  const std::lock_guard<std::mutex> lock(mutex_);
  *is_saved = false;
  std::string why;
  if (settings_.frame.empty() || settings_.file.empty())
    return "set ~cell/region_file, and ~cell/region_frame where neither bin nor target_frame names "
           "one: where a region is kept, and in which frame";
  if (points_.empty())
    return "no point was clicked: publish three or more with rviz's tool Publish Point, or drag a "
           "handle there";
  if (!isOutline(points_, &why))
    return "the region " + why + "; click more corners, or ~clear_region and begin anew";
  try {
    planar_bin_picking::saveRegion(settings_.file, RegionFile{settings_.frame, points_});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  region_.metres = std::move(points_);
  points_.clear();
  show();
  *is_saved = true;
  return "a region of " + std::to_string(region_.metres.size()) +
         " corners is in force and stands in " + settings_.file;
}

bool RegionKeeper::save(Request&, Response& response) {
  bool is_saved = false;
  response.message = saveTaught(&is_saved);
  response.success = is_saved;
  ROS_INFO_STREAM(kSaveRegionService << ": " << response.message);
  return true;
}

std::string RegionKeeper::forgetTaught(bool* is_done) {
  const std::lock_guard<std::mutex> lock(mutex_);
  *is_done = true;
  if (!points_.empty()) {
    const std::string text = std::to_string(points_.size()) + " points are forgotten";
    points_.clear();
    show();
    return text;
  }
  std::error_code error;
  std::filesystem::remove(settings_.file, error);  // that it is not there is no error
  region_.metres = regionOutline(settings_.region);
  show();
  const std::string text = region_.metres.empty() ? "there is no region in metres any more"
                                                  : "the cell's own region is in force";
  *is_done = !error;  // else it would be back at the next start
  return error ? text + ", but " + settings_.file + " cannot be deleted: " + error.message() : text;
}

bool RegionKeeper::clear(Request&, Response& response) {
  bool is_done = false;
  response.message = forgetTaught(&is_done);
  response.success = is_done;
  ROS_INFO_STREAM(kClearRegionService << ": " << response.message);
  return true;
}

void RegionKeeper::show(const bool with_handles) {
  std::string why;
  const bool good = points_.empty() || isOutline(points_, &why);
  const Eigen::Isometry3d T_frame_region = settings_.T_frame_region();
  scene_.show("region",
              regionMarkers(settings_.frame, T_frame_region, region_.metres, points_, good));
  if (!with_handles) return;
  const bool can_save = !settings_.frame.empty() && !settings_.file.empty();
  handles_.show(can_save ? corners() : RegionOutline(), T_frame_region);
}

}  // namespace planar_bin_picking_ros
