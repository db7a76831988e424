// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The file that a calibration wrote -> the camera.

#include "planar_bin_picking/image/camera.h"

#include <string>

namespace planar_bin_picking {

/// Reads a camera_info YAML file in the ROS format.
/// @throws std::runtime_error  naming file and key
Camera loadCamera(const std::string& path);

}  // namespace planar_bin_picking
