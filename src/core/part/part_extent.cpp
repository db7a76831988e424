// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part/part_extent.h"

#include "base/polygon.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace planar_bin_picking {
namespace {

/// An unknown offset of so many metres, taken for tilt, is more than so many radians for a slender
/// part: what a robot's fingers feel.
constexpr double kOffset = 0.1e-3, kTilt = 6.0 * EIGEN_PI / 180.0;
/// The rectangle about the outer contour that has the least area, metres about the centre.
cv::RotatedRect tightest(const PartModel& part) {
  std::vector<cv::Point2f> points;
  for (const Eigen::Vector2d& p : part.file().drawing.loops.front().points) {
    const Eigen::Vector2f q = (p - part.center()).cast<float>();
    points.emplace_back(q.x(), q.y());
  }
  return cv::minAreaRect(points);
}

}  // namespace

Extent extentOf(const PartModel& part) {
  const cv::Size2f size = tightest(part).size;
  return {std::max(size.width, size.height), std::min(size.width, size.height)};
}

std::optional<Eigen::Vector2d> lengthOfSlender(const PartModel& part) {
  const Extent extent = extentOf(part);
  const double cosine = 1.0 - 2.0 * kOffset * (1.0 / extent.width - 1.0 / extent.length);
  if (cosine > std::cos(kTilt)) return std::nullopt;
  std::array<cv::Point2f, 4> corners;
  tightest(part).points(corners.data());
  const cv::Point2f one = corners[1] - corners[0], other = corners[2] - corners[1];
  const cv::Point2f longer = cv::norm(one) > cv::norm(other) ? one : other;
  return Eigen::Vector2d(longer.x, longer.y).normalized();
}

double meanWidthOf(const PartModel& part) {
  double area = 0.0, length = 0.0;
  for (const Loop& loop : part.file().drawing.loops) {
    if (loop.kind == LoopKind::kPrint) continue;
    const double sign = loop.kind == LoopKind::kHole ? -1.0 : 1.0;
    area += sign * std::abs(signedArea(loop.points));
    length += lengthOf(loop);
  }
  return 2.0 * std::max(0.0, area) / length;
}

}  // namespace planar_bin_picking
