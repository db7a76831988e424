// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/board/board.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {

void validate(const Board& board) {
  const auto refuse = [](const std::string& what, double value, const std::string& expected) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << "board: " << what << " is " << value << ", must be " << expected;
    throw std::invalid_argument(text.str());
  };
  // OpenCV's detectors find no board with fewer, and four corners say too little of its tilt.
  constexpr int kFewestCorners = 3, kMostCorners = 100;
  const std::string corners = "3 .. 100 inner corners (one less than there are squares)";
  const auto isCount = [](int n) { return n >= kFewestCorners && n <= kMostCorners; };
  if (!isCount(board.cols)) refuse("cols", board.cols, corners);
  if (!isCount(board.rows)) refuse("rows", board.rows, corners);
  if (!(board.square >= 1e-4 && board.square <= 10.0)) {
    refuse("square", board.square, "0.0001 .. 10 metres");
  }
  if (board.kind != Board::Kind::kCharuco) return;
  // Smaller markers are read badly; larger ones leave no rim in which a corner could be refined.
  constexpr double kLeast = 0.4, kMost = 0.9;
  if (!(board.marker >= kLeast * board.square && board.marker <= kMost * board.square)) {
    refuse("marker", board.marker, "0.4 .. 0.9 of square, in metres");
  }
}

Board parseBoard(const std::string& text, double square, const std::string& key) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  Board board;
  char by = 0;
  if (!(in >> board.cols >> by >> board.rows) || by != 'x' || in.get() != EOF) {
    throw std::invalid_argument(key + " is \"" + text +
                                "\", must be the board's inner corners as COLSxROWS, such as 9x6");
  }
  board.square = square;
  validate(board);
  return board;
}

std::vector<Eigen::Vector3d> Board::points(const std::vector<std::size_t>& ids) const {
  std::vector<Eigen::Vector3d> out;
  for (std::size_t i = 0; ids.empty() && i < size(); ++i) out.push_back(corner(i));
  for (const std::size_t id : ids) out.push_back(corner(id));
  return out;
}

bool Board::operator==(const Board& other) const {
  return cols == other.cols && rows == other.rows && square == other.square && kind == other.kind &&
         marker == other.marker && dictionary == other.dictionary;
}

bool areEnough(const Board& board, const std::vector<std::size_t>& ids) {
  if (ids.size() < kCornersLeast) return false;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const std::size_t id : ids) middle += board.corner(id).head<2>() / board.square;
  const auto count = static_cast<double>(ids.size());
  middle /= count;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const std::size_t id : ids) {
    const Eigen::Vector2d off = board.corner(id).head<2>() / board.square - middle;
    scatter += off * off.transpose() / count;
  }
  // The smaller eigenvalue.
  const double half = 0.5 * scatter.trace();
  const double least = half - std::sqrt(std::max(0.0, half * half - scatter.determinant()));
  return least >= kCornersSpread * kCornersSpread;
}

std::vector<std::vector<std::size_t>> orderings(const Board& board) {
  std::vector<std::size_t> identity(board.size());
  for (std::size_t i = 0; i < identity.size(); ++i) identity[i] = i;
  std::vector<std::vector<std::size_t>> out{identity};
  // Markers tell its corners apart.
  if (board.kind == Board::Kind::kCharuco) return out;
  if ((board.cols + board.rows) % 2 != 0) return out;
  const bool quarter = board.cols == board.rows && board.cols % 2 == 0;
  if (!quarter) {
    out.emplace_back(identity.rbegin(), identity.rend());
    return out;
  }
  for (int turn = 1; turn < 4; ++turn) {
    std::vector<std::size_t> turned(identity.size());
    for (int r = 0; r < board.rows; ++r) {
      for (int c = 0; c < board.cols; ++c) {
        turned[static_cast<std::size_t>(r * board.cols + c)] =
            out.back()[static_cast<std::size_t>(c * board.cols + board.cols - 1 - r)];
      }
    }
    out.push_back(turned);
  }
  return out;
}

}  // namespace planar_bin_picking
