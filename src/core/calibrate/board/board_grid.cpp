// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/board/board_grid.h"

#include "planar_bin_picking/image/grey.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking {

cv::Mat checkedGrey(const cv::Mat& image) {
  if (image.empty() || image.channels() != 1 ||
      (image.depth() != CV_8U && image.depth() != CV_16U)) {
    throw std::invalid_argument("board: the image is empty or not grey of 8 or 16 bit");
  }
  return toEightBits(image);
}

Shrunk::Shrunk(const cv::Mat& full, int largest) {
  const int whole = (std::max(full.cols, full.rows) + largest - 1) / largest;
  factor = static_cast<float>(whole);
  image = full;
  if (whole > 1) cv::resize(full, image, {}, 1.0 / whole, 1.0 / whole, cv::INTER_AREA);
}

void Shrunk::restore(std::vector<cv::Point2f>* corners) const {
  for (cv::Point2f& p : *corners) {
    p = {(p.x + 0.5F) * factor - 0.5F, (p.y + 0.5F) * factor - 0.5F};
  }
}

std::vector<cv::Point2f> sectorBased(const cv::Mat& image, const cv::Size& size) {
  const Shrunk small(image, kSectorSearch);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(small.image, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return {};
  }
  small.restore(&corners);
  return corners;
}

float greyAt(const cv::Mat& image, const cv::Point2f& p) {
  cv::Mat pixel;
  cv::getRectSubPix(image, {3, 3}, p, pixel);
  return static_cast<float>(cv::mean(pixel)[0]);
}

bool allCrossings(const cv::Mat& image, const Board& board,
                  const std::vector<cv::Point2f>& corners) {
  for (int r = 0; r < board.rows; ++r) {
    for (int c = 0; c < board.cols; ++c) {
      const int c0 = std::max(0, c - 1), c1 = std::min(board.cols - 1, c + 1);
      const int r0 = std::max(0, r - 1), r1 = std::min(board.rows - 1, r + 1);
      const cv::Point2f p = at(corners, board, c, r);
      const cv::Point2f u = (0.3F / static_cast<float>(c1 - c0)) *
                            (at(corners, board, c1, r) - at(corners, board, c0, r));
      const cv::Point2f v = (0.3F / static_cast<float>(r1 - r0)) *
                            (at(corners, board, c, r1) - at(corners, board, c, r0));
      const std::pair<float, float> one =
          std::minmax<float>(greyAt(image, p + u + v), greyAt(image, p - u - v));
      const std::pair<float, float> two =
          std::minmax<float>(greyAt(image, p + u - v), greyAt(image, p - u + v));
      if (!(one.first > two.second || two.first > one.second)) return false;
    }
  }
  return true;
}

}  // namespace planar_bin_picking
