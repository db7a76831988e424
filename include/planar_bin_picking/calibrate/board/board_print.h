// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A board to print.

#include "planar_bin_picking/calibrate/board/board.h"

#include <string>

namespace planar_bin_picking {

/// A PDF file of one page, the smallest of A4 to A0 that holds the board, or one of its own size:
/// the board at true size, a ruler along two sides, since printers scale either way differently,
/// and what it is in words. The first square is dark.
/// @throws std::invalid_argument  a bad board
std::string boardPdf(const Board& board);

}  // namespace planar_bin_picking
