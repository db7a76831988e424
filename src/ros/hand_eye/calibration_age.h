// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a cell may use a calibration: how good it was found to be, and how old it is.

#include <string>

namespace planar_bin_picking_ros {

struct CalibrationAge {
  std::string verdict;  ///< "" where no file says it
  double days = 0.0;
};

/// @param path  of hand_eye.yaml or camera_info.yaml; verdict and date as for checkUsable
/// @throws std::runtime_error  the file is not there, or not what it should be
CalibrationAge calibrationAge(const std::string& path);

/// The verdict is taken from hand_eye.yaml, or from calibration.yaml beside it; the date likewise
/// (ISO 8601), or else from when the file was written.
/// @param path          of hand_eye.yaml
/// @param max_age_days  0 = of any age
/// @throws std::runtime_error  what is wrong with it, and how it is used all the same
void checkUsable(const std::string& path, bool accept_poor, double max_age_days);

}  // namespace planar_bin_picking_ros
