// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/board/charuco.h"

#include "calibrate/board/markers.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace planar_bin_picking {
namespace {

/// Square (column, row) -> marker in the picture.
using Placed = std::map<std::pair<int, int>, const SeenMarker*>;

/// Corners of a marker on the board, in squares from the first inner corner.
std::vector<cv::Point2f> markerOnBoard(const Board& board, int col, int row) {
  const auto half = static_cast<float>(0.5 * board.marker / board.square);
  const cv::Point2f middle(static_cast<float>(col) - 0.5F, static_cast<float>(row) - 0.5F);
  return {middle + cv::Point2f(-half, -half), middle + cv::Point2f(half, -half),
          middle + cv::Point2f(half, half), middle + cv::Point2f(-half, half)};
}

/// The markers whose four corners fit one common view of the board.
Placed place(const std::vector<SeenMarker>& seen, const Board& board, bool first_is_dark) {
  const std::vector<MarkerSquare> squares = markerSquares(board, first_is_dark);
  std::vector<cv::Point2f> on_board, in_image;
  std::vector<const SeenMarker*> known;
  std::vector<double> sides;
  for (const SeenMarker& marker : seen) {
    if (marker.number < 0 || marker.number >= static_cast<int>(squares.size())) continue;
    const MarkerSquare& square = squares[static_cast<std::size_t>(marker.number)];
    const std::vector<cv::Point2f> corners = markerOnBoard(board, square.col, square.row);
    on_board.insert(on_board.end(), corners.begin(), corners.end());
    in_image.insert(in_image.end(), marker.corners.begin(), marker.corners.end());
    known.push_back(&marker);
    sides.push_back(cv::norm(marker.corners[1] - marker.corners[0]));
  }
  if (known.empty()) return {};
  std::nth_element(sides.begin(), sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2),
                   sides.end());
  // A lens bends the board by less than this share of a marker; markers of another place are off by
  // more than a whole one.
  constexpr double kOff = 0.4;
  std::vector<unsigned char> fits;
  if (cv::findHomography(on_board, in_image, cv::RANSAC, kOff * sides[sides.size() / 2], fits)
          .empty()) {
    return {};
  }
  Placed placed;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (!std::all_of(&fits[4 * i], &fits[4 * i] + 4, [](unsigned char fit) { return fit != 0; })) {
      continue;
    }
    const MarkerSquare& square = squares[static_cast<std::size_t>(known[i]->number)];
    placed[{square.col, square.row}] = known[i];
  }
  return placed;
}

/// The picture about a corner: where it is expected, and how squares lead away from it.
struct Around {
  cv::Point2f corner, along, down;
};

/// From the two markers that touch the corner; nothing where one of them is not seen.
std::optional<Around> around(const Placed& placed, const Board& board, int col, int row) {
  std::vector<cv::Point2f> on_board, in_image;
  for (const auto& [c, r] :
       {std::pair(col, row), {col + 1, row}, {col, row + 1}, {col + 1, row + 1}}) {
    const auto marker = placed.find({c, r});
    if (marker == placed.end()) continue;
    const std::vector<cv::Point2f> corners = markerOnBoard(board, c, r);
    on_board.insert(on_board.end(), corners.begin(), corners.end());
    in_image.insert(in_image.end(), marker->second->corners.begin(), marker->second->corners.end());
  }
  constexpr std::size_t kTwoMarkers = 8;
  if (in_image.size() != kTwoMarkers) return std::nullopt;
  const cv::Mat H = cv::findHomography(on_board, in_image, 0);
  if (H.empty()) return std::nullopt;
  const auto x = static_cast<float>(col), y = static_cast<float>(row);
  const std::vector<cv::Point2f> squares{
      {x, y}, {x + 0.5F, y}, {x - 0.5F, y}, {x, y + 0.5F}, {x, y - 0.5F}};
  std::vector<cv::Point2f> p;
  cv::perspectiveTransform(squares, p, H);
  return Around{p[0], p[1] - p[2], p[3] - p[4]};
}

/// Refines the corner within the light rims about its markers.
/// @return  nothing where no corner is: the rims are too narrow, or something covers it
std::optional<cv::Point2f> refine(const cv::Mat& image, const Board& board, const Around& at) {
  const auto rim = static_cast<float>(0.5 * (1.0 - board.marker / board.square));
  const double reach = rim * std::min(cv::norm(at.along), cv::norm(at.down));
  // With less than two pixels of a rim its grey is that of its neighbours.
  constexpr double kRimLeast = 2.0;
  constexpr int kWindowMost = 25;
  if (reach < kRimLeast) return std::nullopt;
  const int window = std::clamp(static_cast<int>(reach), 2, kWindowMost);
  std::vector<cv::Point2f> corner{at.corner};
  const cv::Rect inside(window + 1, window + 1, image.cols - 2 * window - 2,
                        image.rows - 2 * window - 2);
  if (!inside.contains(cv::Point(corner[0]))) return std::nullopt;
  cv::cornerSubPix(image, corner, {window, window}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
  if (cv::norm(corner[0] - at.corner) > reach) return std::nullopt;
  const auto grey = [&](float u, float v) {
    cv::Mat pixel;
    cv::getRectSubPix(image, {1, 1}, corner[0] + u * at.along + v * at.down, pixel, CV_32F);
    return pixel.at<float>(0);
  };
  const float off = 0.6F * rim;
  const auto one = std::minmax({grey(off, off), grey(-off, -off)});
  const auto two = std::minmax({grey(off, -off), grey(-off, off)});
  if (!(one.first > two.second || two.first > one.second)) return std::nullopt;
  return corner[0];
}

}  // namespace

BoardCorners findCharuco(const cv::Mat& image, const Board& board) {
  const std::vector<SeenMarker> seen = findMarkers(image, board);
  Placed placed = place(seen, board, true);
  Placed other = place(seen, board, false);
  if (other.size() > placed.size()) placed.swap(other);
  BoardCorners out;
  for (int row = 0; row < board.rows; ++row) {
    for (int col = 0; col < board.cols; ++col) {
      const auto at = around(placed, board, col, row);
      const auto corner = at ? refine(image, board, *at) : std::nullopt;
      if (!corner) continue;
      out.corners.push_back(*corner);
      out.ids.push_back(static_cast<std::size_t>(row * board.cols + col));
    }
  }
  if (!areEnough(board, out.ids)) return {};
  return out;
}

}  // namespace planar_bin_picking
