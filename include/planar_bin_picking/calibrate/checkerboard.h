// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Image -> inner corners of a checkerboard. Frame `board`: origin at the first corner, x along a
/// row of `cols` corners, y along a column, z away from a camera that sees the board
/// (right-handed).

#include "planar_bin_picking/base/types.h"

#include <opencv2/core/mat.hpp>

#include <array>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// What a user reads off the board.
struct Board {
  int cols = 0, rows = 0;  ///< inner corners
  double square = 0.0;     ///< side of a square, metres

  std::size_t size() const {
    return static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows);
  }
  /// Corner i in the frame `board`, row by row; z = 0.
  Eigen::Vector3d corner(std::size_t i) const {
    const int k = static_cast<int>(i);
    return {square * (k % cols), square * (k / cols), 0.0};
  }
};

/// @throws std::invalid_argument  fewer than 2 x 2 or more than 100 x 100 inner corners, or a
/// square
///         that is not between 0.1 mm and 10 m: which, and what it was
void validate(const Board& board);

/// Parses "9x6". @throws std::invalid_argument  what it was and what is expected
Board parseBoard(const std::string& text, double square);

/// How one picture of the board came out.
struct BoardSighting {
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

/// Finds the board by OpenCV's sector-based detector, and where that one fails, by its classic one
/// (which comes second since it may take minutes where there is only part of a board); then refines
/// the corners to sub-pixels in a window that fits the squares.
/// @param image     grey, 8 or 16 bit
/// @param blur_max  largest edge_px allowed, pixels
/// @return  corners in an order that the board's looks allow: rows and columns as stated,
/// right-handed as
///          seen from the front, and the first square dark where the colours tell the ends apart.
///          What is left open is listed by orderings()
/// @throws std::invalid_argument  image empty or of another type; a bad board
BoardSighting findBoard(const cv::Mat& image, const Board& board, double blur_max);

/// The board looks the same after these reorderings of its corners (a turn by 180 degrees where
/// both numbers are even or both are odd; by 90 degrees, too, where they are equal and even): entry
/// k lists which detected corner stands at each place. The first one is the identity.
std::vector<std::vector<std::size_t>> orderings(const Board& board);

/// Where no picture shows the stated board: the number of inner corners of a board that is seen in
/// most of the pictures, as "8x6", or "" if there is none. Tries what one miscounts: one more or
/// less, squares in place of inner corners.
std::string findOtherBoard(const std::vector<cv::Mat>& images, const Board& board);

}  // namespace planar_bin_picking
