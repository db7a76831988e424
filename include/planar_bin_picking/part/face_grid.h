// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planar_bin_picking/drawing/drawing.h"

#include <opencv2/core/mat.hpp>

#include <vector>

namespace planar_bin_picking {

/// A part's face, its holes left out, as square cells in rows along x and y of the part frame; the
/// same for both faces. 40 cells along its longer side, more where it is narrow everywhere.
class FaceGrid {
 public:
  /// Two cells side by side (`along_x`) or one above the other.
  struct Link {
    int first, second;  ///< cells
    int col, row;       ///< of the first
    bool along_x;
  };

  static constexpr int kSamples = 4;  ///< along a cell's side, wherever a face is sampled finely

  explicit FaceGrid(const Drawing& drawing);

  double cellSize() const { return cell_size_; }  ///< metres
  /// Middles of the cells, part frame, metres.
  const std::vector<Eigen::Vector2d>& cells() const { return cells_; }
  const std::vector<Link>& links() const { return links_; }

  int cols() const { return index_.cols; }
  int rows() const { return index_.rows; }
  /// 0 <= col <= cols(), the same for rows; part frame, metres.
  Eigen::Vector2d corner(int col, int row) const {
    return origin_ + cell_size_ * Eigen::Vector2d(col, row);
  }
  /// The cell about a point of the part frame or next to it; -1 where there is none.
  int cellNear(const Eigen::Vector2d& point) const;
  /// To the nearest line of the drawing, in samples; [rows() * kSamples][cols() * kSamples].
  const cv::Mat_<float>& fromOutline() const { return from_outline_; }

 private:
  /// @param half_full  cells with less material than half of them are left out
  void divide(const Drawing& drawing, double across, bool half_full);

  double cell_size_ = 0.0;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();  ///< of corner 0, 0
  cv::Mat_<int> index_;                               ///< of the cell there; -1 off the face
  cv::Mat_<float> from_outline_;
  std::vector<Eigen::Vector2d> cells_;
  std::vector<Link> links_;
};

}  // namespace planar_bin_picking
