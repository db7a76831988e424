// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Image -> inner corners of the board.

#include "planar_bin_picking/calibrate/board/board.h"

#include <opencv2/core/mat.hpp>

#include <vector>

namespace planar_bin_picking {

/// How one picture of the board came out.
struct BoardObservation {
  enum class Status {
    kFound,     ///< all corners, or enough of a board with markers, to sub-pixels
    kNotFound,  ///< no board of that many inner corners, or too little of one with markers
    kBlurred,   ///< found, but its edges are wider than `blur_max` allows: out of focus or moving
  };
  Status status = Status::kNotFound;
  std::vector<Eigen::Vector2d>
      corners;                   ///< pixels, in the order of Board::corner; empty unless found
  std::vector<std::size_t> ids;  ///< which of the corners they are; empty: all of them
  double edge_px = 0.0;    ///< width of the squares' edges (one standard deviation of the blur)
  double square_px = 0.0;  ///< the shortest side of a square in the image
};

/// Edges of the squares wider than this, pixels, say that the camera was not in focus, or moved.
inline constexpr double kBlurMaxPx = 4.0;

/// Finds the board, and refines its corners to sub-pixels in a window that fits the squares.
/// @param image     grey, 8 or 16 bit
/// @param blur_max  largest edge_px allowed, pixels
/// @return  corners in an order that the board's looks allow: rows and columns as stated,
/// right-handed as seen from the front, and the first square dark where the colours tell the ends
/// apart. What is left open is listed by orderings(). With markers, the corners that are seen.
/// @throws std::invalid_argument  image empty or of another type; a bad board
BoardObservation findBoard(const cv::Mat& image, const Board& board, double blur_max);

}  // namespace planar_bin_picking
