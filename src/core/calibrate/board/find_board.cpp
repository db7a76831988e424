// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/board/find_board.h"

#include "calibrate/board/board_grid.h"
#include "calibrate/board/charuco.h"
#include "calibrate/board/checkerboard.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <map>

namespace planar_bin_picking {
namespace {

/// Side of a square in the image.
using Side = std::pair<cv::Point2f, cv::Point2f>;

struct Sides {
  std::vector<Side> along, down;  ///< along rows, along columns
};

/// Between corners that were seen.
Sides sidesOf(const Board& board, const BoardCorners& seen) {
  std::map<std::size_t, cv::Point2f> corners;
  for (std::size_t i = 0; i < seen.corners.size(); ++i) {
    corners[seen.ids.empty() ? i : seen.ids[i]] = seen.corners[i];
  }
  const auto cols = static_cast<std::size_t>(board.cols);
  Sides sides;
  for (const auto& [id, p] : corners) {
    const auto right = corners.find(id + 1), below = corners.find(id + cols);
    if ((id + 1) % cols != 0 && right != corners.end()) sides.along.emplace_back(p, right->second);
    if (below != corners.end()) sides.down.emplace_back(p, below->second);
  }
  return sides;
}

double shortestOf(const Sides& sides) {
  double shortest = 1e9;
  for (const auto* const list : {&sides.along, &sides.down}) {
    for (const Side& side : *list) {
      shortest = std::min(shortest, cv::norm(side.second - side.first));
    }
  }
  return shortest;
}

/// Grey values across the middle of a side, half a pixel apart.
std::vector<float> profileAcross(const cv::Mat& image, const Side& side, int reach) {
  const cv::Point2f along = side.second - side.first, across(-along.y, along.x);
  const cv::Point2f step = across * (0.5F / static_cast<float>(cv::norm(across)));
  std::vector<float> profile;
  for (int k = -2 * reach; k <= 2 * reach; ++k) {
    cv::Mat pixel;
    cv::getRectSubPix(image, {1, 1},
                      0.5F * (side.first + side.second) + static_cast<float>(k) * step, pixel,
                      CV_32F);
    profile.push_back(pixel.at<float>(0));
  }
  return profile;
}

/// Spread of the blurred edge between two squares: contrast over its steepest slope, taken across
/// the middle of sides all over the board.
double edgeWidth(const cv::Mat& image, const std::vector<Side>& sides, double side) {
  const int reach = std::max(3, static_cast<int>(0.35 * side));
  std::vector<double> widths;
  for (const Side& between : sides) {
    const std::vector<float> profile = profileAcross(image, between, reach);
    float steepest = 0.0F;
    for (std::size_t k = 2; k < profile.size(); ++k) {
      steepest = std::max(steepest, std::abs(profile[k] - profile[k - 2]));
    }
    const auto [low, high] = std::minmax_element(profile.begin(), profile.end());
    // A blurred step of height h and spread s has the slope h / (s * sqrt(2 pi)).
    if (steepest > 0.0F) widths.push_back((*high - *low) / steepest / 2.5066);
  }
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return widths.empty() ? 0.0 : *middle;
}

/// Half the side of the window in which corners are refined: as large as it can be without reaching
/// the neighbours, since every pixel of an edge counts.
int windowOf(double side) { return std::clamp(static_cast<int>(0.35 * side), 2, 25); }

BoardCorners findAll(const cv::Mat& image, const Board& board) {
  return {findCheckerboard(image, board), {}};
}

}  // namespace

BoardObservation findBoard(const cv::Mat& image, const Board& board, double blur_max) {
  validate(board);
  const cv::Mat grey = checkedGrey(image);
  const bool has_markers = board.kind == Board::Kind::kCharuco;
  BoardObservation out;
  BoardCorners seen = has_markers ? findCharuco(grey, board) : findAll(grey, board);
  if (seen.corners.empty()) return out;
  const Sides sides = sidesOf(board, seen);
  out.square_px = shortestOf(sides);
  // Those between markers are refined already.
  const int window = windowOf(out.square_px);
  if (!has_markers) {
    cv::cornerSubPix(grey, seen.corners, {window, window}, {-1, -1},
                     {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
  }
  out.edge_px = edgeWidth(grey, sides.along, out.square_px);
  if (out.edge_px > blur_max) {
    out.status = BoardObservation::Status::kBlurred;
    return out;
  }
  out.status = BoardObservation::Status::kFound;
  for (const cv::Point2f& p : seen.corners) out.corners.emplace_back(p.x, p.y);
  if (seen.corners.size() < board.size()) out.ids = seen.ids;
  return out;
}

}  // namespace planar_bin_picking
