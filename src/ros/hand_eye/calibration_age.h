// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a cell may use a calibration: how good it was found to be, and how old it is.

#include <string>

namespace planar_bin_picking_ros {

/// The verdict is taken from hand_eye.yaml, or from calibration.yaml beside it; the date likewise
/// (ISO 8601), or else from when the file was written.
/// @param path          of hand_eye.yaml
/// @param max_age_days  0 = of any age
/// @throws std::runtime_error  what is wrong with it, and how it is used all the same
void checkUsable(const std::string& path, bool accept_poor, double max_age_days);

}  // namespace planar_bin_picking_ros
