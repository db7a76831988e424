// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Is a calibration still good? One to three new views are held against it: does what they show
/// differ from what is expected by more than calibration, robot and corners are uncertain, and if
/// so, what must have moved to explain it?
///
/// Each explanation frees one part of the chain of hand_eye.h, holds the others where the
/// calibration has them, within its covariance, and is as good as the sum of squares that it
/// leaves, in standard deviations.

#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

struct CalibrationCheck {
  enum class Finding {
    kHolds,          ///< nothing has moved by more than is expected
    kBoardMoved,     ///< the board alone: the calibration holds
    kCameraMoved,    ///< on its mount
    kLensChanged,    ///< focal length or principal point
    kCameraOrBoard,  ///< something moved, and these views cannot tell which
    kUnexplained,    ///< none of these explains what is seen
  };
  Finding finding = Finding::kUnexplained;
  double moved_mm = 0.0, moved_deg = 0.0;        ///< of camera or board
  double expected_mm = 0.0, expected_deg = 0.0;  ///< up to this, three standard deviations
  double focal_percent = 0.0;                    ///< where the lens changed: by how much
  std::string text;                              ///< all of it in a sentence, with a remedy
  bool holds() const { return finding == Finding::kHolds || finding == Finding::kBoardMoved; }
};

/// @param problem     that the calibration was made of
/// @param calibrated  its result: solved
/// @param views       1 to 3, with the corners of that board
/// @throws std::invalid_argument  no views or too many, a wrong number of corners, not solved
CalibrationCheck checkCalibration(const HandEyeProblem& problem, const HandEyeResult& calibrated,
                                  const std::vector<Observation>& views);

}  // namespace planar_bin_picking
