// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Finds the inner corners of a ChArUco board, as many as are seen: the markers in its light
/// squares tell which is which.

#include "planar_bin_picking/calibrate/board/board.h"

#include <opencv2/core.hpp>

#include <vector>

namespace planar_bin_picking {

struct BoardCorners {
  std::vector<cv::Point2f> corners;
  std::vector<std::size_t> ids;  ///< which each is, ascending; empty: all of the board's
};

/// A corner counts where both markers that touch it are seen, and light and dark squares meet there
/// crosswise. Either square may be the dark one at the board's beginning.
/// @param image  grey, 8 bit
/// @return  to sub-pixels, or nothing where there are not enough (areEnough())
/// @throws std::invalid_argument  an unknown dictionary, or one with too few markers
BoardCorners findCharuco(const cv::Mat& image, const Board& board);

}  // namespace planar_bin_picking
