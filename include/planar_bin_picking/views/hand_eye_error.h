// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a calibration says of its own error: `hand_eye.yaml`, expected_error_mm and _deg.

#include <string>

namespace planar_bin_picking {

/// Standard deviations of the hand-eye transform, per axis.
struct HandEyeError {
  double metres = 0.0, degrees = 0.0;
};

/// The file has the length of the expected error; an axis has its share of it.
/// @throws std::runtime_error  naming file, key and value
HandEyeError loadHandEyeError(const std::string& path);

}  // namespace planar_bin_picking
