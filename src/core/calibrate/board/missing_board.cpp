// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/board/missing_board.h"

#include "calibrate/board/board_grid.h"
#include "calibrate/board/crossings.h"
#include "calibrate/board/markers.h"

#include <algorithm>
#include <utility>

namespace planar_bin_picking {
namespace {

/// Whether the next corners beyond the grid would be outside the picture.
bool touchesBorder(const cv::Size& image, const Board& grid,
                   const std::vector<cv::Point2f>& corners) {
  constexpr float kSquares = 1.2F;
  const auto is_outside = [&](const cv::Point2f& edge, const cv::Point2f& inner) {
    const cv::Point2f p = edge + kSquares * (edge - inner);
    return p.x < 0.0F || p.y < 0.0F || p.x > static_cast<float>(image.width - 1) ||
           p.y > static_cast<float>(image.height - 1);
  };
  const int last_col = grid.cols - 1, last_row = grid.rows - 1;
  for (int r = 0; r < grid.rows; ++r) {
    if (is_outside(at(corners, grid, 0, r), at(corners, grid, 1, r))) return true;
    if (is_outside(at(corners, grid, last_col, r), at(corners, grid, last_col - 1, r))) return true;
  }
  for (int c = 0; c < grid.cols; ++c) {
    if (is_outside(at(corners, grid, c, 0), at(corners, grid, c, 1))) return true;
    if (is_outside(at(corners, grid, c, last_row), at(corners, grid, c, last_row - 1))) return true;
  }
  return false;
}

enum class PartOfBoard { kNone, kInside, kCutOff };

/// Whether some of a checkerboard is seen, and whether the picture's border cuts it off. The
/// detectors look for whole grids; of a board that is cut off aslant there is none left.
PartOfBoard partOfBoard(const cv::Mat& image) {
  const std::vector<Crossing> crossings = findCrossings(image);
  const std::vector<bool> on_squares = onSquares(crossings);
  constexpr std::ptrdiff_t kFewest = 6;  // two squares
  if (std::count(on_squares.begin(), on_squares.end(), true) < kFewest) return PartOfBoard::kNone;
  return leavePicture(crossings, on_squares, image.size()) ? PartOfBoard::kCutOff
                                                           : PartOfBoard::kInside;
}

/// Nobody needs all pictures to see a miscount: some, evenly spread.
std::vector<cv::Mat> someOf(const std::vector<cv::Mat>& images) {
  std::vector<cv::Mat> some;
  const std::size_t step = std::max<std::size_t>(1, images.size() / 6);
  for (std::size_t i = 0; i < images.size(); i += step) some.push_back(checkedGrey(images[i]));
  return some;
}

std::string whyMarkersAreMissing(const std::vector<cv::Mat>& images, const Board& board) {
  std::size_t most = 0;
  for (const cv::Mat& image : someOf(images)) {
    most = std::max(most, findMarkers(image, board).size());
  }
  if (most == 0) {
    return "no board: the pictures show no marker of " + board.dictionary +
           "; check the dictionary, and that the board is in view, lit and in focus";
  }
  return "too little of the board: the pictures show up to " + std::to_string(most) +
         " of its markers; a corner counts where both markers that touch it are seen, and " +
         std::to_string(kCornersLeast) +
         " of them in two rows are needed; move the board to the middle, and check corners and "
         "marker as they are stated";
}

}  // namespace

std::string findOtherBoard(const std::vector<cv::Mat>& images, const Board& board) {
  const std::vector<cv::Mat> some = someOf(images);
  std::vector<std::size_t> crossings;
  for (const cv::Mat& image : some) crossings.push_back(findCrossings(image).size());
  // What one miscounts: one more or less, squares in place of inner corners.
  for (const auto& [dc, dr] : {std::pair(-1, -1),
                               {-1, 0},
                               {0, -1},
                               {1, 0},
                               {0, 1},
                               {1, 1},
                               {-1, 1},
                               {1, -1},
                               {-2, -2},
                               {2, 2}}) {
    const cv::Size size(board.cols + dc, board.rows + dr);
    if (size.width < 3 || size.height < 3) continue;
    // Of a board that is half out of view as many corners may be seen in each picture; but then the
    // next ones would be outside of all.
    std::size_t seen = 0, whole = 0;
    for (std::size_t i = 0; i < some.size(); ++i) {
      // Each search takes its time; where far fewer crossings are seen, it finds nothing.
      if (3 * crossings[i] < 2 * static_cast<std::size_t>(size.area())) continue;
      const std::vector<cv::Point2f> corners = sectorBased(some[i], size);
      if (corners.empty()) continue;
      ++seen;
      const Board grid{size.width, size.height, 1.0};
      whole += touchesBorder(some[i].size(), grid, corners) ? 0 : 1;
    }
    if (whole == 0 || 2 * seen <= some.size()) continue;
    return std::to_string(size.width) + "x" + std::to_string(size.height);
  }
  return "";
}

std::string whyBoardIsMissing(const std::vector<cv::Mat>& images, const Board& board) {
  if (board.kind == Board::Kind::kCharuco) return whyMarkersAreMissing(images, board);
  const std::string stated = std::to_string(board.cols) + "x" + std::to_string(board.rows);
  const std::string other = findOtherBoard(images, board);
  if (!other.empty()) {
    return "inner corners miscounted: most pictures show a board of " + other +
           " inner corners, stated are " + stated + "; set the board to that";
  }
  bool is_seen = false;
  for (const cv::Mat& image : someOf(images)) {
    const PartOfBoard part = partOfBoard(image);
    if (part == PartOfBoard::kCutOff) {
      return "board partly out of view: its edge leaves the picture; all " + stated +
             " inner corners must be seen: move the board to the middle, the camera farther away, "
             "or "
             "use a smaller board";
    }
    is_seen = is_seen || part == PartOfBoard::kInside;
  }
  if (is_seen) {
    return "part of a board: the pictures show fewer than " + stated +
           " inner corners of a checkerboard; count them, and check that nothing covers the board "
           "or "
           "shines on it";
  }
  return "no board: the pictures show no checkerboard; check that it is in view, lit and in focus, "
         "and "
         "that it has " +
         stated + " inner corners";
}

}  // namespace planar_bin_picking
