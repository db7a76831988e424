// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Why pictures do not show the board that they should.

#include "planar_bin_picking/calibrate/board/board.h"

#include <opencv2/core/mat.hpp>

#include <string>
#include <vector>

namespace planar_bin_picking {

/// Where no picture shows the stated board: the number of inner corners of a board that is seen
/// whole in most of the pictures, as "8x6", or "" if there is none.
std::string findOtherBoard(const std::vector<cv::Mat>& images, const Board& board);

/// Why pictures in which findBoard() found nothing do not show the stated board, and what to do:
/// its corners are miscounted, it is partly out of view, or there is none.
std::string whyBoardIsMissing(const std::vector<cv::Mat>& images, const Board& board);

}  // namespace planar_bin_picking
