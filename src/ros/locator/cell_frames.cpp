// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/cell_frames.h"

#include "locator/bin_range.h"
#include "locator/plane_frame.h"
#include "shared/refusal.h"

#include <planar_bin_picking/LocatePart.h>

#include <chrono>

namespace planar_bin_picking_ros {

using planar_bin_picking::LocateRequest;

Eigen::Isometry3d CellFrames::transform(const std::string& target, const std::string& source,
                                        const ros::Time& stamp) const {
  if (target == source) return Eigen::Isometry3d::Identity();
  const LookupResult found =
      lookup(buffer_, target, source, stamp, std::chrono::duration<double>(cell_.tf_timeout));
  if (!found.T_target_source) {
    throw Refusal(planar_bin_picking::LocatePart::Response::NO_TRANSFORM,
                  "no transform from " + source + " to " + target +
                      " at the image's stamp: " + found.reason +
                      "; check that the robot publishes tf and the hand-eye calibration");
  }
  return *found.T_target_source;
}

LocateRequest CellFrames::request(const std_msgs::Header& image) const {
  DistanceRange range{cell_.distance_min, cell_.distance_max};
  if (cell_.hasBin())
    range = distanceRange(cell_, transform(image.frame_id, cell_.bin_frame, image.stamp));
  LocateRequest request;
  request.distance_min = range.min;
  request.distance_max = range.max;
  request.max_parts = 0;
  if (!cell_.plane_frame.empty()) {
    request.plane =
        planeOfFrame(cell_.plane_frame, transform(image.frame_id, cell_.plane_frame, image.stamp));
  }
  return request;
}

PickKeeper::Frames CellFrames::pickFrames(const std_msgs::Header& answer,
                                          const Eigen::Isometry3d& T_target_camera) const {
  PickKeeper::Frames frames{T_target_camera, std::nullopt};
  if (!cell_.hasBin()) return frames;
  frames.bin.emplace();
  frames.bin->T_bin_target = transform(cell_.bin_frame, answer.frame_id, answer.stamp);
  frames.bin->min = Eigen::Vector3d(cell_.bin_min[0], cell_.bin_min[1], cell_.bin_min[2]);
  frames.bin->max = Eigen::Vector3d(cell_.bin_max[0], cell_.bin_max[1], cell_.bin_max[2]);
  return frames;
}

}  // namespace planar_bin_picking_ros
