// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/face_grid.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace planar_bin_picking {
namespace {

// Cells along the longer side: a cell of some 2 mm is finer than a tool; and at most, for the time.
constexpr double kAcross = 40.0, kMostAcross = 320.0;
constexpr std::size_t kFewCells = 60;  // fewer do not tell a visible share to some per cent
constexpr int kShift = 4;              // of OpenCV's fractional pixels

std::vector<cv::Point> toSamples(const Loop& loop, const Eigen::Vector2d& origin, double spacing) {
  std::vector<cv::Point> line;
  for (const Eigen::Vector2d& p : loop.points) {
    // The middle of sample 0 is half a spacing off the origin.
    const Eigen::Vector2d q =
        ((p - origin) / spacing - Eigen::Vector2d::Constant(0.5)) * (1 << kShift);
    line.emplace_back(static_cast<int>(std::lround(q.x())), static_cast<int>(std::lround(q.y())));
  }
  return line;
}

}  // namespace

FaceGrid::FaceGrid(const Drawing& drawing) {
  // A frame or ring may be so narrow that coarse cells miss it.
  for (double across = kAcross; across <= kMostAcross && cells_.size() < kFewCells; across *= 2.0)
    divide(drawing, across, across < kMostAcross);
  for (int row = 0; row + 1 < rows(); ++row) {
    for (int col = 0; col + 1 < cols(); ++col) {
      const int here = index_(row, col), right = index_(row, col + 1), below = index_(row + 1, col);
      if (here >= 0 && right >= 0) links_.push_back({here, right, col, row, true});
      if (here >= 0 && below >= 0) links_.push_back({here, below, col, row, false});
    }
  }
}

void FaceGrid::divide(const Drawing& drawing, double across, bool half_full) {
  Eigen::AlignedBox2d box;
  for (const auto& p : drawing.loops.front().points) box.extend(p);
  cell_size_ = box.sizes().maxCoeff() / across;
  origin_ = box.min() - Eigen::Vector2d::Constant(cell_size_);
  const auto cellsOver = [&](double length) {
    return static_cast<int>(std::ceil(length / cell_size_)) + 2;  // an empty one on either side
  };
  index_ = cv::Mat_<int>(cellsOver(box.sizes().y()), cellsOver(box.sizes().x()), -1);

  const cv::Size fine(kSamples * cols(), kSamples * rows());
  cv::Mat_<std::uint8_t> inside(fine, std::uint8_t{0}), off_lines(fine, std::uint8_t{1});
  std::vector<std::vector<cv::Point>> contours;
  for (const Loop& loop : drawing.loops) {
    const auto line = toSamples(loop, origin_, cell_size_ / kSamples);
    cv::polylines(off_lines, line, loop.closed, cv::Scalar(0), 1, cv::LINE_8, kShift);
    if (loop.kind != LoopKind::kPrint) contours.push_back(line);
  }
  cv::fillPoly(inside, contours, cv::Scalar(1), cv::LINE_8, kShift);  // even-odd: without holes
  cv::distanceTransform(off_lines, from_outline_, cv::DIST_L2, cv::DIST_MASK_5);

  cells_.clear();
  const int least = half_full ? kSamples * kSamples / 2 : 1;
  for (int row = 0; row < rows(); ++row) {
    for (int col = 0; col < cols(); ++col) {
      const cv::Rect cell(kSamples * col, kSamples * row, kSamples, kSamples);
      if (cv::countNonZero(inside(cell)) < least) continue;
      index_(row, col) = static_cast<int>(cells_.size());
      cells_.push_back(corner(col, row) + Eigen::Vector2d::Constant(0.5 * cell_size_));
    }
  }
}

int FaceGrid::cellNear(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d q = (point - origin_) / cell_size_;
  const int col = static_cast<int>(std::floor(q.x())), row = static_cast<int>(std::floor(q.y()));
  int best = -1;
  double nearest = 0.0;
  for (int y = std::max(0, row - 1); y <= std::min(rows() - 1, row + 1); ++y) {
    for (int x = std::max(0, col - 1); x <= std::min(cols() - 1, col + 1); ++x) {
      const int cell = index_(y, x);
      if (cell < 0) continue;
      const double d = (cells_[cell] - point).squaredNorm();
      if (best < 0 || d < nearest) best = cell, nearest = d;
    }
  }
  return best;
}

}  // namespace planar_bin_picking
