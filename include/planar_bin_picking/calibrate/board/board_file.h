// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A board described by a YAML file, for the calibrator, calibrate_samples and draw_board alike:
///
///     kind: charuco            # or checkerboard
///     corners: 9x6             # inner corners, columns x rows: one less than there are squares
///     square: 0.02             # side of a square, metres
///     marker: 0.015            # side of a marker, metres; charuco alone
///     dictionary: DICT_4X4_50  # of the markers, as OpenCV names it; charuco alone

#include "planar_bin_picking/calibrate/board/board.h"

namespace planar_bin_picking {

/// @throws std::runtime_error  naming file, key, value and what it must be
Board loadBoard(const std::string& path);

/// "checkerboard" or "charuco". @throws std::invalid_argument  another kind: which
Board::Kind parseKind(const std::string& text);
std::string nameOf(Board::Kind kind);

}  // namespace planar_bin_picking
