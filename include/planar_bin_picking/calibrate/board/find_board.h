// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Image -> inner corners of a checkerboard.

#include "planar_bin_picking/calibrate/board/board.h"

#include <opencv2/core/mat.hpp>

#include <string>
#include <vector>

namespace planar_bin_picking {

/// How one picture of the board came out.
struct BoardObservation {
  enum class Status {
    kFound,     ///< all corners, to sub-pixels
    kNotFound,  ///< no board of that many inner corners
    kBlurred,   ///< found, but its edges are wider than `blur_max` allows: out of focus or moving
  };
  Status status = Status::kNotFound;
  std::vector<Eigen::Vector2d>
      corners;             ///< pixels, in the order of Board::corner; empty unless found
  double edge_px = 0.0;    ///< width of the squares' edges (one standard deviation of the blur)
  double square_px = 0.0;  ///< the shortest side of a square in the image
};

/// Edges of the squares wider than this, pixels, say that the camera was not in focus, or moved.
inline constexpr double kBlurMaxPx = 4.0;

/// Finds the board by OpenCV's sector-based detector, and where that one fails, by its classic one
/// (which comes second since it may take minutes where there is only part of a board), and by the
/// first again in a finer image; then refines the corners to sub-pixels in a window that fits the
/// squares.
/// @param image     grey, 8 or 16 bit
/// @param blur_max  largest edge_px allowed, pixels
/// @return  corners in an order that the board's looks allow: rows and columns as stated,
/// right-handed as
///          seen from the front, and the first square dark where the colours tell the ends apart.
///          What is left open is listed by orderings()
/// @throws std::invalid_argument  image empty or of another type; a bad board
BoardObservation findBoard(const cv::Mat& image, const Board& board, double blur_max);

/// Where no picture shows the stated board: the number of inner corners of a board that is seen
/// whole in most of the pictures, as "8x6", or "" if there is none.
std::string findOtherBoard(const std::vector<cv::Mat>& images, const Board& board);

/// Why pictures in which findBoard() found nothing do not show the stated board, and what to do:
/// its corners are miscounted, it is partly out of view, or there is none.
std::string whyBoardIsMissing(const std::vector<cv::Mat>& images, const Board& board);

}  // namespace planar_bin_picking
