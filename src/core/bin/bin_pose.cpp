// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/bin/bin_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kDegrees = EIGEN_PI / 180.0;

Loop ringOf(const BinBox& bin, const double grown, const LoopKind kind) {
  const double x0 = bin.min.x() - grown, y0 = bin.min.y() - grown;
  const double x1 = bin.max.x() + grown, y1 = bin.max.y() + grown;
  Loop loop;
  loop.kind = kind;
  loop.points = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  if (kind == LoopKind::kHole) std::reverse(loop.points.begin(), loop.points.end());
  return loop;
}

/// From the camera to the rim, wherever within twice the limits the bin stands: what is beyond them
/// is to be found, too, so that it can be named.
Distances distancesTo(const BinSearch& search) {
  const BinBox& bin = search.told;
  const double half = 0.5 * (bin.max - bin.min).head<2>().norm() + search.wall;
  const double margin =
      2.0 * search.moved_max + half * std::sin(2.0 * search.tilted_max_deg * kDegrees);
  Distances range{std::numeric_limits<double>::infinity(), 0.0};
  for (const double x : {bin.min.x(), bin.max.x()}) {
    for (const double y : {bin.min.y(), bin.max.y()}) {
      const double z = (bin.T_camera_bin * Eigen::Vector3d(x, y, bin.max.z())).z();
      range.min = std::min(range.min, z - margin);
      range.max = std::max(range.max, z + margin);
    }
  }
  range.min = std::max(range.min, kDistanceLeast);
  return range;
}

/// Of the poses in which the rim looks the same, the one that is turned least.
FoundBin nearest(const BinSearch& search, const PartModel& rim, const Detection& detection) {
  const Symmetry& symmetry = rim.symmetry();
  const Eigen::Translation3d center(symmetry.center.x(), symmetry.center.y(), 0.0);
  const Eigen::Translation3d top(0.0, 0.0,
                                 -search.told.max.z());  // of the bin, from its rim's frame
  FoundBin best;
  const int order = std::max(1, symmetry.order);
  for (int i = 0; i < order; ++i) {
    const Eigen::AngleAxisd turn(2.0 * EIGEN_PI * i / order, Eigen::Vector3d::UnitZ());
    const Eigen::Isometry3d T_camera_found =
        detection.T_camera_part * center * turn * center.inverse() * top;
    const FoundBin found = foundAt(search, search.told.T_camera_bin.inverse() * T_camera_found);
    if (i == 0 || std::abs(found.turned_deg) < std::abs(best.turned_deg)) best = found;
  }
  best.score = detection.score;
  return best;
}

}  // namespace

FoundBin foundAt(const BinSearch& search, const Eigen::Isometry3d& T_told_found) {
  FoundBin found;
  found.T_told_found = T_told_found;
  const Eigen::Vector2d middle = 0.5 * (search.told.min + search.told.max).head<2>();
  const Eigen::Vector3d rim(middle.x(), middle.y(), search.told.max.z());
  found.moved = (T_told_found * rim - rim).norm();
  const Eigen::Matrix3d R = T_told_found.linear();
  found.turned_deg = std::atan2(R(1, 0), R(0, 0)) / kDegrees;
  found.tilted_deg = std::acos(std::clamp(R(2, 2), -1.0, 1.0)) / kDegrees;
  found.is_within = found.moved <= search.moved_max &&
                    std::abs(found.turned_deg) <= search.turned_max_deg &&
                    found.tilted_deg <= search.tilted_max_deg;
  return found;
}

PartFile rimOf(const BinSearch& search) {
  const Eigen::Vector3d size = search.told.max - search.told.min;
  if (!(size.minCoeff() > 0.0)) throw std::invalid_argument("the bin's box has no size");
  if (!(search.wall > 0.0)) throw std::invalid_argument("the bin's walls have no size");
  PartFile file;
  file.name = "the bin's rim";
  file.drawing.loops.push_back(ringOf(search.told, search.wall, LoopKind::kOuter));
  file.drawing.loops.push_back(ringOf(search.told, 0.0, LoopKind::kHole));
  return file;
}

std::optional<FoundBin> findBin(const cv::Mat& image, const Camera& camera, const BinSearch& search,
                                const Locator& locator) {
  LocateRequest request;
  request.parts = {std::make_shared<const PartModel>(rimOf(search))};
  const Distances range = distancesTo(search);
  request.distance_min = range.min;
  request.distance_max = range.max;
  request.face = FaceFilter::kFront;  // its z points out of the bin, toward the camera
  const LocateResult result = locator.locate(image, camera, request);
  std::optional<FoundBin> best;
  for (const Detection& detection : result.detections) {  // best first
    const FoundBin found = nearest(search, *request.parts.front(), detection);
    if (!best || (found.is_within && !best->is_within)) best = found;
  }
  return best;
}

}  // namespace planar_bin_picking
