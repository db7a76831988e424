// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part/part_extent.h"

#include "base/polygon.h"

#include <opencv2/imgproc.hpp>

#include <cmath>
#include <vector>

namespace planar_bin_picking {

Extent extentOf(const PartModel& part) {
  std::vector<cv::Point2f> points;
  for (const Eigen::Vector2d& p : part.file().drawing.loops.front().points) {
    const Eigen::Vector2f q = (p - part.center()).cast<float>();
    points.emplace_back(q.x(), q.y());
  }
  const cv::Size2f size = cv::minAreaRect(points).size;
  return {std::max(size.width, size.height), std::min(size.width, size.height)};
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
