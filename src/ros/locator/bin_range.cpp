// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/bin_range.h"

#include "planar_bin_picking/locate/locator.h"
#include "shared/refusal.h"

#include <planar_bin_picking/LocatePart.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>

namespace planar_bin_picking_ros {

using planar_bin_picking::Detection;

namespace {

/// The part's outer contour, camera frame.
std::vector<Eigen::Vector3d> outlineOf(const Answer& answer, const Detection& detection) {
  const planar_bin_picking::PartModel& part = *answer.parts[detection.part];
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector2d& p : part.file().drawing.loops.front().points) {
    points.push_back(detection.T_camera_part *
                     Eigen::Vector3d(p.x(), p.y(), part.faceZ(detection.face)));
  }
  return points;
}

}  // namespace

DistanceRange distanceRange(const CellParams& cell, const Eigen::Isometry3d& T_camera_bin) {
  DistanceRange range{std::numeric_limits<double>::infinity(),
                      -std::numeric_limits<double>::infinity()};
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d x_bin;
    for (int i = 0; i < 3; ++i) x_bin[i] = (corner >> i & 1 ? cell.bin_max : cell.bin_min)[i];
    const double z = (T_camera_bin * x_bin).z();
    range.min = std::min(range.min, z);
    range.max = std::max(range.max, z);
  }
  if (range.min <= 0.0) {
    char message[200];
    std::snprintf(message, sizeof message,
                  "the bin reaches from %.3f to %.3f m along the optical axis, that is, behind the "
                  "camera; check ~cell/bin_frame, bin_min, bin_max and the camera's calibration",
                  range.min, range.max);
    throw Refusal(planar_bin_picking::LocatePart::Response::BAD_BIN, message);
  }
  try {
    planar_bin_picking::checkDistances(range.min, range.max);
  } catch (const std::invalid_argument& error) {
    throw Refusal(planar_bin_picking::LocatePart::Response::BAD_BIN,
                  std::string("along the optical axis the bin's box makes ") + error.what() +
                      "; check ~cell/bin_frame, bin_min, bin_max and where the camera stands");
  }
  return range;
}

planar_bin_picking::FloorCover lookIntoBin(const CellParams& cell,
                                           const Eigen::Isometry3d& T_camera_bin,
                                           const Answer& answer) {
  planar_bin_picking::BinBox box{T_camera_bin, Eigen::Vector3d(cell.bin_min.data()),
                                 Eigen::Vector3d(cell.bin_max.data())};
  std::vector<std::vector<Eigen::Vector3d>> located;
  for (const Detection& detection : answer.result.detections)
    located.push_back(outlineOf(answer, detection));
  for (const auto& withheld : answer.result.withheld)
    located.push_back(outlineOf(answer, withheld.detection));
  return planar_bin_picking::findFloorCover(answer.grey, answer.camera, box, located);
}

}  // namespace planar_bin_picking_ros
