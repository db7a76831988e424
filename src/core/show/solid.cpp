// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/show/solid.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace planar_bin_picking {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// The part's contours without prints.
std::vector<Points> simplified(const PartModel& part) {
  constexpr double kTolerance = 0.01;  // of the part's radius
  std::vector<Points> contours;
  for (const Loop& loop : part.file().drawing.loops) {
    if (loop.kind == LoopKind::kPrint) continue;
    std::vector<cv::Point2f> all, few;
    for (const Eigen::Vector2d& p : loop.points) {
      // Single precision is enough about the part's centre, wherever the drawing has its origin.
      const Eigen::Vector2d here = p - part.center();
      all.emplace_back(static_cast<float>(here.x()), static_cast<float>(here.y()));
    }
    cv::approxPolyDP(all, few, kTolerance * part.radius(), true);
    if (few.size() < 3) continue;  // a hole that nobody sees
    Points points;
    for (const cv::Point2f& p : few) points.push_back(part.center() + Eigen::Vector2d(p.x, p.y));
    contours.push_back(std::move(points));
  }
  return contours;
}

/// Where a strip's lower and upper border cross a side of a contour.
struct Cut {
  double low = 0.0, high = 0.0;
};

std::vector<Cut> cutsOf(const std::vector<Points>& contours, const double low, const double high) {
  std::vector<Cut> cuts;
  for (const Points& points : contours) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::Vector2d a = points[i], b = points[(i + 1) % points.size()];
      if (a.y() > b.y()) std::swap(a, b);
      if (a.y() > low || b.y() < high) continue;
      const double slope = (b.x() - a.x()) / (b.y() - a.y());
      cuts.push_back({a.x() + slope * (low - a.y()), a.x() + slope * (high - a.y())});
    }
  }
  std::sort(cuts.begin(), cuts.end(),
            [](const Cut& s, const Cut& t) { return s.low + s.high < t.low + t.high; });
  return cuts;
}

/// Three corners each, counter-clockwise: the strips between the contours' corners, in each of
/// which only sides lie that run through it, so that material lies between every other two.
Points faceTriangles(const std::vector<Points>& contours) {
  std::vector<double> heights;
  for (const Points& points : contours)
    for (const Eigen::Vector2d& p : points) heights.push_back(p.y());
  std::sort(heights.begin(), heights.end());
  heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
  Points triangles;
  for (std::size_t i = 1; i < heights.size(); ++i) {
    const double low = heights[i - 1], high = heights[i];
    const auto cuts = cutsOf(contours, low, high);
    for (std::size_t k = 1; k < cuts.size(); k += 2) {
      const Cut &left = cuts[k - 1], &right = cuts[k];
      const Eigen::Vector2d a(left.low, low), b(right.low, low), c(right.high, high),
          d(left.high, high);
      triangles.insert(triangles.end(), {a, b, c, a, c, d});
    }
  }
  return triangles;
}

}  // namespace

std::vector<Eigen::Vector3d> solidTriangles(const PartModel& part) {
  const auto contours = simplified(part);
  const double back = part.faceZ(Face::kBack);
  const Points face = faceTriangles(contours);
  std::vector<Eigen::Vector3d> out;
  for (const Eigen::Vector2d& p : face) out.emplace_back(p.x(), p.y(), 0.0);
  if (back == 0.0) return out;
  for (std::size_t i = face.size(); i-- > 0;) out.emplace_back(face[i].x(), face[i].y(), back);
  for (const Points& points : contours) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d &p = points[i], &q = points[(i + 1) % points.size()];
      const Eigen::Vector3d a(p.x(), p.y(), 0.0), b(p.x(), p.y(), back), c(q.x(), q.y(), back),
          d(q.x(), q.y(), 0.0);
      out.insert(out.end(), {a, b, c, a, c, d});
    }
  }
  return out;
}

}  // namespace planar_bin_picking
