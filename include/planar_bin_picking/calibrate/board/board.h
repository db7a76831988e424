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

/// The board looks the same after these reorderings of its corners (a turn by 180 degrees where
/// both numbers are even or both are odd; by 90 degrees, too, where they are equal and even): entry
/// k lists which detected corner stands at each place. The first one is the identity.
std::vector<std::vector<std::size_t>> orderings(const Board& board);

}  // namespace planar_bin_picking
