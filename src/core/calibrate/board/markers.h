// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The markers of a ChArUco board, by OpenCV's aruco module, whose interface changed with OpenCV
/// 4.7.

#include "planar_bin_picking/calibrate/board/board.h"

#include <opencv2/core.hpp>

#include <vector>

namespace planar_bin_picking {

/// Which square a marker fills: column and row, counted from the board's first square.
struct MarkerSquare {
  int col = 0, row = 0;
};

/// The square of each marker, in the order of their numbers: row by row, all light ones.
/// @param first_is_dark  the board's first square; older versions of OpenCV print boards with an
/// even number of rows of squares the other way
std::vector<MarkerSquare> markerSquares(const Board& board, bool first_is_dark);

/// Each module of a marker, its dark rim included: 0 dark, 255 light.
/// @throws std::invalid_argument  an unknown dictionary, or one with too few markers
cv::Mat_<unsigned char> markerModules(const Board& board, int number);

/// @throws std::invalid_argument  likewise
void checkDictionary(const Board& board);

struct SeenMarker {
  int number = 0;
  std::vector<cv::Point2f> corners;  ///< four, clockwise from the marker's first
};

/// @param image  grey, 8 bit
std::vector<SeenMarker> findMarkers(const cv::Mat& image, const Board& board);

}  // namespace planar_bin_picking
