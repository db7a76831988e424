// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What can be seen of a checkerboard of any size, however little of it is in view.

#include <opencv2/core.hpp>

#include <vector>

namespace planar_bin_picking {

/// A place where light and dark squares meet crosswise.
struct Crossing {
  cv::Point2f at;                 ///< pixels, to a pixel or two
  std::vector<std::size_t> next;  ///< at the other end of a square's side
};

/// All of them, with the sides of squares that join them.
/// @param image  8 bit
std::vector<Crossing> findCrossings(const cv::Mat& image);

/// Which of them are corners of whole squares. Parts in a bin have many crossings, some of them
/// joined, but no squares of such.
std::vector<bool> onSquares(const std::vector<Crossing>& crossings);

/// Whether the board goes on beyond the picture's border: where the next crossing behind one of its
/// squares would be.
/// @param on_squares  see above
bool leavePicture(const std::vector<Crossing>& crossings, const std::vector<bool>& on_squares,
                  const cv::Size& image);

}  // namespace planar_bin_picking
