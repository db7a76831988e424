// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Searches a picture for a whole checkerboard.

#include "planar_bin_picking/calibrate/board/board.h"

#include <opencv2/core.hpp>

#include <vector>

namespace planar_bin_picking {

/// By OpenCV's sector-based detector, and where that one fails, by its classic one, which comes
/// second since it may take minutes where there is only part of a board.
/// @param image  grey, 8 bit
/// @return  the corners to about a pixel, in an order that the board's looks allow; or none
std::vector<cv::Point2f> findCheckerboard(const cv::Mat& image, const Board& board);

}  // namespace planar_bin_picking
