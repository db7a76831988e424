// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The camera's place at one picture, on disk, as an entry of `samples.yaml` has the flange's:
///
///     position: [x, y, z]            # metres
///     orientation: [x, y, z, w]

#include <Eigen/Geometry>

#include <string>

namespace planar_bin_picking {

/// @throws std::runtime_error  naming file, key and value
Eigen::Isometry3d loadPose(const std::string& path);

}  // namespace planar_bin_picking
