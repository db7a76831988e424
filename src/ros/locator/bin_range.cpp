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
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::Detection;
using planar_bin_picking::Region;

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

BinFinder::Settings binSettings(const CellParams& cell) {
  BinFinder::Settings settings{
      cell.bin_frame, cell.target_frame, {}, Eigen::Isometry3d::Identity()};
  if (!cell.hasBin()) return settings;
  settings.search.told.min = Eigen::Vector3d(cell.bin_min.data());
  settings.search.told.max = Eigen::Vector3d(cell.bin_max.data());
  settings.search.wall = cell.bin_wall;
  settings.search.moved_max = cell.bin_moved_max;
  settings.search.turned_max_deg = cell.bin_turned_max_deg;
  settings.search.tilted_max_deg = cell.bin_tilted_max_deg;
  settings.T_told_found = foundBin(cell);
  return settings;
}

Eigen::Isometry3d foundBin(const CellParams& cell) {
  const std::vector<double>& found = cell.bin_found;
  if (found.empty()) return Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond turn(found[6], found[3], found[4], found[5]);
  return Eigen::Translation3d(found[0], found[1], found[2]) * turn.normalized();
}

std::vector<double> foundBin(const Eigen::Isometry3d& T_told_found) {
  if (T_told_found.matrix() == Eigen::Matrix4d::Identity()) return {};
  const Eigen::Vector3d p = T_told_found.translation();
  const Eigen::Quaterniond q(T_told_found.linear());
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

planar_bin_picking::RegionOutline floorOf(const CellParams& cell) {
  const auto &min = cell.bin_min, &max = cell.bin_max;
  return planar_bin_picking::regionOutline(std::vector<double>{min[0], min[1], max[0], max[1]});
}

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

Eigen::Vector3d floorNormal(const CellParams& cell, const Eigen::Isometry3d& T_camera_bin) {
  const Eigen::Vector3d middle =
      0.5 * (Eigen::Vector3d(cell.bin_min.data()) + Eigen::Vector3d(cell.bin_max.data()));
  const Eigen::Vector3d up = T_camera_bin.linear().col(2);
  return up.dot(T_camera_bin * middle) < 0.0 ? up : Eigen::Vector3d(-up);
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

std::optional<planar_bin_picking::PixelBox> windowOf(
    const SeenRegion& region, const planar_bin_picking::Camera& camera,
    const planar_bin_picking::LocateRequest& request) {
  if (region.region.isEverywhere()) return std::nullopt;
  // What covers a part is seen about it, and its face may be somewhat nearer than asked for.
  constexpr double kAbout = 1.3;
  double radius = 0.0;
  for (const auto& part : request.parts) radius = std::max(radius, part->radius());
  return planar_bin_picking::windowOf(region.region, camera, region.T_region_camera,
                                      {request.distance_min, request.distance_max},
                                      kAbout * radius);
}

void keepWithin(const SeenRegion& region, Answer* answer) {
  if (region.region.isEverywhere()) return;
  std::vector<Detection> within;
  for (const Detection& detection : answer->result.detections) {
    const planar_bin_picking::PartModel& part = *answer->parts[detection.part];
    const Eigen::Vector3d center =
        detection.T_camera_part *
        Eigen::Vector3d(part.center().x(), part.center().y(), part.faceZ(detection.face));
    const auto why = planar_bin_picking::outsideOf(region.region, answer->camera,
                                                   region.T_region_camera, center);
    if (why) {
      answer->result.withheld.push_back({detection, planar_bin_picking::Withheld::kOutside, *why});
    } else {
      within.push_back(detection);
    }
  }
  answer->result.detections = std::move(within);
}

void addOutlines(const CellParams& cell, const std::optional<Eigen::Isometry3d>& T_camera_bin,
                 const SeenRegion& region, Answer* answer) {
  const auto add = [&](const planar_bin_picking::RegionOutline& outline, const double z,
                       const Eigen::Isometry3d& T_camera_outline) {
    if (outline.empty()) return;
    answer->outlines.emplace_back();
    for (const Eigen::Vector2d& p : outline)
      answer->outlines.back().push_back(T_camera_outline * Eigen::Vector3d(p.x(), p.y(), z));
  };
  if (T_camera_bin) {
    for (const double z : {cell.bin_min[2], cell.bin_max[2]}) add(floorOf(cell), z, *T_camera_bin);
  }
  add(region.region.metres, 0.0, region.T_region_camera.inverse());
  if (region.region.pixels.empty()) return;
  answer->outlines.emplace_back();
  for (const Eigen::Vector2d& pixel : region.region.pixels)
    answer->outlines.back().push_back(answer->camera.undistort(pixel).homogeneous());
}

}  // namespace planar_bin_picking_ros
