// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/board/checkerboard.h"

#include "calibrate/board/board_grid.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// The classic detector takes a minute and more to give up where a board is partly visible in a
/// grainy image (87 s at 0.8 Mpx); in one of this size and smooth it takes about a second.
constexpr int kClassicSearch = 700;

std::vector<cv::Point2f> classicAsItIs(const cv::Mat& image, const cv::Size& size) {
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, {}, 1.0);
  std::vector<cv::Point2f> corners;
  const int flags =
      cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  if (!cv::findChessboardCorners(smooth, size, corners, flags)) return {};
  return corners;
}

std::vector<cv::Point2f> classic(const cv::Mat& image, const cv::Size& size) {
  const Shrunk small(image, kClassicSearch);
  std::vector<cv::Point2f> corners = classicAsItIs(small.image, size);
  small.restore(&corners);
  return corners;
}

/// Right-handed as seen from the front: the columns' direction is the rows' turned clockwise.
void makeRightHanded(const Board& board, std::vector<cv::Point2f>* corners) {
  const cv::Point2f along = at(*corners, board, board.cols - 1, 0) - at(*corners, board, 0, 0);
  const cv::Point2f down = at(*corners, board, 0, board.rows - 1) - at(*corners, board, 0, 0);
  if (along.x * down.y - along.y * down.x > 0.0F) return;
  for (int r = 0; r < board.rows; ++r) {
    const auto begin = corners->begin() + r * board.cols;
    std::reverse(begin, begin + board.cols);
  }
}

/// Larger images are made smaller before small boards are looked for.
constexpr int kFineSearch = 3000;

/// For small boards in large images, which shrinking would lose: the classic detector in tiles of
/// the size that it searches fast. Half a tile is the largest board that surely lies within one.
std::vector<cv::Point2f> classicInTiles(const cv::Mat& image, const Board& board) {
  constexpr int kStep = kClassicSearch / 2;
  const Shrunk fine(image, kFineSearch);
  const cv::Rect whole(0, 0, fine.image.cols, fine.image.rows);
  for (int y = 0; y == 0 || y + kStep < whole.height; y += kStep) {
    for (int x = 0; x == 0 || x + kStep < whole.width; x += kStep) {
      const cv::Rect tile = cv::Rect(x, y, kClassicSearch, kClassicSearch) & whole;
      auto corners = classicAsItIs(fine.image(tile), {board.cols, board.rows});
      for (cv::Point2f& p : corners) p += cv::Point2f(tile.tl());
      fine.restore(&corners);
      if (!corners.empty() && allCrossings(image, board, corners)) return corners;
    }
  }
  return {};
}

/// Standard deviation of the grain, grey levels, from the median of what is left when all that is
/// smooth is taken off (Immerkaer 1996).
double grainOf(const cv::Mat& image) {
  const cv::Mat kernel = (cv::Mat_<float>(3, 3) << 1, -2, 1, -2, 4, -2, 1, -2, 1);
  constexpr double kGain = 6.0, kMedianOfNormal = 0.6745;
  cv::Mat left;
  cv::filter2D(image, left, CV_32F, kernel);
  std::vector<float> values;
  constexpr int kStep = 7;  // some pixels are enough
  for (int y = 0; y < left.rows; y += kStep) {
    for (int x = 0; x < left.cols; x += kStep) values.push_back(std::abs(left.at<float>(y, x)));
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle / (kGain * kMedianOfNormal);
}

/// Boards that neither survive smoothing nor shrinking: both detectors in the image as it is, the
/// classic one where there is no grain to keep it busy.
std::vector<cv::Point2f> slantedAndSmall(const cv::Mat& image, const Board& board) {
  const cv::Size size(board.cols, board.rows);
  if (std::max(image.cols, image.rows) > kFineSearch) return {};
  std::vector<cv::Point2f> corners;
  if (cv::findChessboardCornersSB(image, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE) &&
      allCrossings(image, board, corners)) {
    return corners;
  }
  constexpr double kGrainMost = 1.0;
  if (grainOf(image) > kGrainMost) return {};
  const int flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE;
  if (!cv::findChessboardCorners(image, size, corners, flags)) return {};
  if (!allCrossings(image, board, corners)) return {};
  return corners;
}

std::vector<cv::Point2f> searched(const cv::Mat& image, const Board& board) {
  const cv::Size size(board.cols, board.rows);
  std::vector<cv::Point2f> corners = sectorBased(image, size);
  if (!corners.empty() && allCrossings(image, board, corners)) return corners;
  corners = classic(image, size);
  if (!corners.empty() && allCrossings(image, board, corners)) return corners;
  // The sector-based detector has searched all that is smaller as it is.
  if (std::max(image.cols, image.rows) <= kSectorSearch) return {};
  corners = classicInTiles(image, board);
  if (!corners.empty()) return corners;
  return slantedAndSmall(image, board);
}

/// How much darker the first square is than its neighbours.
float darknessOfFirst(const cv::Mat& image, const Board& board,
                      const std::vector<cv::Point2f>& corners) {
  float dark = 0.0F;
  for (int r = 0; r + 1 < board.rows; ++r) {
    for (int c = 0; c + 1 < board.cols; ++c) {
      const cv::Point2f centre =
          0.25F * (at(corners, board, c, r) + at(corners, board, c + 1, r) +
                   at(corners, board, c, r + 1) + at(corners, board, c + 1, r + 1));
      // Of an even number of squares in a row each has a partner of the other colour.
      dark += ((c + r) % 2 == 0 ? -1.0F : 1.0F) * (greyAt(image, centre) - 127.5F);
    }
  }
  return dark;
}

/// Turned by 90 degrees; for boards with as many columns as rows.
std::vector<cv::Point2f> quarterTurn(const Board& board, const std::vector<cv::Point2f>& corners) {
  std::vector<cv::Point2f> out(corners.size());
  for (int r = 0; r < board.rows; ++r) {
    for (int c = 0; c < board.cols; ++c) {
      out[static_cast<std::size_t>(r * board.cols + c)] = at(corners, board, board.cols - 1 - r, c);
    }
  }
  return out;
}

/// Where colours tell one end from the other, the first square is the dark one.
void startAtDark(const cv::Mat& image, const Board& board, std::vector<cv::Point2f>* corners) {
  if (darknessOfFirst(image, board, *corners) >= 0.0F) return;
  if ((board.cols + board.rows) % 2 != 0) {
    std::reverse(corners->begin(), corners->end());
  } else if (board.cols == board.rows && board.cols % 2 != 0) {
    *corners = quarterTurn(board, *corners);
  }
}

}  // namespace

std::vector<cv::Point2f> findCheckerboard(const cv::Mat& image, const Board& board) {
  std::vector<cv::Point2f> corners = searched(image, board);
  if (corners.empty()) return corners;
  makeRightHanded(board, &corners);
  startAtDark(image, board, &corners);
  return corners;
}

}  // namespace planar_bin_picking
