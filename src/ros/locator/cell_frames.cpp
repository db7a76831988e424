// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/cell_frames.h"

#include "locator/bin_range.h"
#include "locator/plane_frame.h"
#include "shared/convert.h"
#include "shared/refusal.h"

#include <planar_bin_picking/LocatePart.h>

#include <chrono>
#include <cmath>

namespace planar_bin_picking_ros {

using planar_bin_picking::LocateRequest;
using Response = planar_bin_picking::LocatePart::Response;

Eigen::Isometry3d CellFrames::transform(const std::string& target, const std::string& source,
                                        const ros::Time& stamp) const {
  if (target == source) return Eigen::Isometry3d::Identity();
  const LookupResult found =
      lookup(buffer_, target, source, stamp, std::chrono::duration<double>(tf_timeout_));
  if (!found.T_target_source) {
    throw Refusal(Response::NO_TRANSFORM,
                  "no transform from " + source + " to " + target +
                      " at the image's stamp: " + found.reason +
                      "; check that the robot publishes tf and the hand-eye calibration");
  }
  return *found.T_target_source;
}

Standing CellFrames::at(const CellParams& cell, const std_msgs::Header& image,
                        const std::string& target,
                        const geometry_msgs::TransformStamped& flange) const {
  Eigen::Isometry3d T_camera_base = Eigen::Isometry3d::Identity();
  const bool is_told = !flange.child_frame_id.empty();
  if (is_told) {
    T_camera_base = transform(image.frame_id, flange.child_frame_id, image.stamp) *
                    fromMsg(flange.transform).inverse();
  }
  const auto fromCamera = [&](const std::string& frame) -> Eigen::Isometry3d {
    if (!is_told || frame == image.frame_id) return transform(image.frame_id, frame, image.stamp);
    return T_camera_base * transform(flange.header.frame_id, frame, image.stamp);
  };
  Standing standing;
  standing.pick.T_target_camera = fromCamera(target).inverse();
  if (cell.hasBin()) {
    standing.T_camera_bin = fromCamera(cell.bin_frame) * foundBin(cell);
    standing.pick.bin.emplace();
    standing.pick.bin->T_bin_target =
        (standing.pick.T_target_camera * *standing.T_camera_bin).inverse();
    standing.pick.bin->min = Eigen::Vector3d(cell.bin_min.data());
    standing.pick.bin->max = Eigen::Vector3d(cell.bin_max.data());
  }
  if (!cell.plane_frame.empty()) standing.T_camera_plane = fromCamera(cell.plane_frame);
  const std::string& region = cell.regionFrame();
  if (cell.hasBin() && region == cell.bin_frame) {
    standing.T_region_camera = standing.T_camera_bin->inverse();
  } else if (!region.empty()) {
    standing.T_region_camera = fromCamera(region).inverse();
  }
  return standing;
}

LocateRequest CellFrames::request(const CellParams& cell, const Standing& standing) const {
  DistanceRange range{cell.distance_min, cell.distance_max};
  LocateRequest request;
  if (standing.T_camera_bin) {
    range = distanceRange(cell, *standing.T_camera_bin);
    request.floor_normal = floorNormal(cell, *standing.T_camera_bin);
  }
  request.distance_min = range.min;
  request.distance_max = range.max;
  request.max_parts = 0;
  if (standing.T_camera_plane)
    request.plane = planeOfFrame(cell.plane_frame, *standing.T_camera_plane);
  return request;
}

void checkFlange(const geometry_msgs::TransformStamped& flange) {
  const std::string &parent = flange.header.frame_id, &child = flange.child_frame_id;
  if (parent.empty() && child.empty()) return;
  const auto refuse = [](const std::string& why) {
    throw Refusal(Response::BAD_REQUEST, "flange: " + why);
  };
  if (parent.empty() || child.empty())
    refuse(
        "header.frame_id has to name the robot's base and child_frame_id the flange, as tf does");
  const auto& p = flange.transform.translation;
  const auto& q = flange.transform.rotation;
  const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  constexpr double kOff = 1e-3;  // of a unit quaternion that was rounded to four digits
  if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z) ||
      !(std::abs(length - 1.0) <= kOff))
    refuse("its transform is none: the translation must be numbers, the rotation of length 1");
}

}  // namespace planar_bin_picking_ros
