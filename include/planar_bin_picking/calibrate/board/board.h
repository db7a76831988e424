// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The calibration board. Frame `board`: origin at the first corner, x along a row of `cols`
/// corners, y along a column, z away from a camera that sees the board (right-handed).

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// What a user reads off the board.
struct Board {
  enum class Kind {
    kCheckerboard,  ///< all of its inner corners have to be seen
    kCharuco,       ///< with markers in its light squares, so that a part of it is enough
  };
  int cols = 0, rows = 0;  ///< inner corners
  double square = 0.0;     ///< side of a square, metres
  Kind kind = Kind::kCheckerboard;
  double marker = 0.0;       ///< side of a marker, metres; 0 without markers
  std::string dictionary{};  ///< that the markers are of, as OpenCV names it; "" without markers

  std::size_t size() const {
    return static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows);
  }
  /// Corner i in the frame `board`, row by row; z = 0.
  Eigen::Vector3d corner(std::size_t i) const {
    const int k = static_cast<int>(i);
    return {square * (k % cols), square * (k / cols), 0.0};
  }
  /// Those corners. @param ids  empty: all, in order
  std::vector<Eigen::Vector3d> points(const std::vector<std::size_t>& ids = {}) const;

  bool operator==(const Board& other) const;
  bool operator!=(const Board& other) const { return !(*this == other); }
};

/// @throws std::invalid_argument  fewer than 3 x 3 or more than 100 x 100 inner corners, or a
/// square
///         that is not between 0.1 mm and 10 m, or markers that do not fit into it: which, and what
///         it was
void validate(const Board& board);

/// Parses "9x6".
/// @param key  what the user calls it, for the message
/// @throws std::invalid_argument  what it was and what is expected
Board parseBoard(const std::string& text, double square, const std::string& key = "board");

/// The fewest corners of a part of a board that count, and how far apart they have to lie at least
/// across the direction in which they lie farthest apart, RMS, squares: nearly in a row, or fewer,
/// they say too little of where the board is. Two rows are half a square from their middle.
inline constexpr std::size_t kCornersLeast = 6;
inline constexpr double kCornersSpread = 0.45;

/// Whether these corners are enough to count.
bool areEnough(const Board& board, const std::vector<std::size_t>& ids);

/// The board looks the same after these reorderings of its corners (a turn by 180 degrees where
/// both numbers are even or both are odd; by 90 degrees, too, where they are equal and even): entry
/// k lists which detected corner stands at each place. The first one is the identity.
std::vector<std::vector<std::size_t>> orderings(const Board& board);

}  // namespace planar_bin_picking
