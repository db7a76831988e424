// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the searches for a checkerboard share: pictures made smaller, grids of corners, and the
/// looks of a corner.

#include "planar_bin_picking/calibrate/board/board.h"

#include <opencv2/core.hpp>

#include <vector>

namespace planar_bin_picking {

/// 8 bit. @throws std::invalid_argument  image empty or not grey of 8 or 16 bit
cv::Mat checkedGrey(const cv::Mat& image);

/// The image made smaller by a whole number, and its corners back in full size. Corners are refined
/// in the full image anyway.
struct Shrunk {
  cv::Mat image;
  float factor = 1.0F;

  Shrunk(const cv::Mat& full, int largest);
  /// Pixel (0, 0) is a pixel's centre in both.
  void restore(std::vector<cv::Point2f>* corners) const;
};

/// Larger images are made smaller before the sector-based detector searches them: it takes 0.2 s
/// then.
constexpr int kSectorSearch = 1400;

/// OpenCV's sector-based detector; empty where it finds nothing.
std::vector<cv::Point2f> sectorBased(const cv::Mat& image, const cv::Size& size);

/// Of a grid of corners, row by row.
inline const cv::Point2f& at(const std::vector<cv::Point2f>& corners, const Board& board, int col,
                             int row) {
  return corners[static_cast<std::size_t>(row * board.cols + col)];
}

/// Mean over a few pixels.
float greyAt(const cv::Mat& image, const cv::Point2f& p);

/// Whether light and dark squares meet crosswise at every corner. A detector may take for corners
/// what the edge of the paper and the outermost squares form.
bool allCrossings(const cv::Mat& image, const Board& board,
                  const std::vector<cv::Point2f>& corners);

}  // namespace planar_bin_picking
