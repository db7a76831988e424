// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Holds the calibration in output_folder against what the camera sees now. Changes nothing.

#include "calibrator/board_look.h"
#include "planar_bin_picking/calibrate/calibration_check.h"
#include "planar_bin_picking/calibrate/sample_folder.h"

#include <chrono>
#include <vector>

namespace planar_bin_picking_ros {

class CalibrationVerifier {
 public:
  explicit CalibrationVerifier(const CalibratorParams& params) : params_(params) {}

  /// Checks this view, with those before it that are not older than ten minutes and from elsewhere.
  /// @param look  with the board
  /// @throws std::runtime_error  no calibration is there, or not with the pictures it was made of
  planar_bin_picking::CalibrationCheck verify(const Look& look,
                                              const planar_bin_picking::HandEyeProblem& empty);

 private:
  using Clock = std::chrono::steady_clock;
  struct View {
    planar_bin_picking::Observation observation;
    Clock::time_point taken;
  };
  struct Calibration {
    planar_bin_picking::SampleSet set;
    planar_bin_picking::HandEyeResult result;
  };
  Calibration calibration(const planar_bin_picking::HandEyeProblem& empty) const;
  void remember(const Look& look);

  const CalibratorParams& params_;
  std::vector<View> views_;  // the oldest first
};

}  // namespace planar_bin_picking_ros
