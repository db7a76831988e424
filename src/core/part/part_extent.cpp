// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part/part_extent.h"

#include <opencv2/imgproc.hpp>

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

}  // namespace planar_bin_picking
