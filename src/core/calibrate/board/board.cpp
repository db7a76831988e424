// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/board/board.h"

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
  const std::string corners = "2 .. 100 inner corners (one less than there are squares)";
  if (board.cols < 2 || board.cols > 100) refuse("cols", board.cols, corners);
  if (board.rows < 2 || board.rows > 100) refuse("rows", board.rows, corners);
  if (!(board.square >= 1e-4 && board.square <= 10.0)) {
    refuse("square", board.square, "0.0001 .. 10 metres");
  }
}

Board parseBoard(const std::string& text, double square) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  Board board;
  char by = 0;
  if (!(in >> board.cols >> by >> board.rows) || by != 'x' || in.get() != EOF) {
    throw std::invalid_argument("board is \"" + text +
                                "\", must be its inner corners as COLSxROWS, such as 9x6");
  }
  board.square = square;
  validate(board);
  return board;
}

std::vector<std::vector<std::size_t>> orderings(const Board& board) {
  std::vector<std::size_t> identity(board.size());
  for (std::size_t i = 0; i < identity.size(); ++i) identity[i] = i;
  std::vector<std::vector<std::size_t>> out{identity};
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
