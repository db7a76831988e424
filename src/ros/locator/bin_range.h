// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How near and how far a bin reaches along the optical axis.

#include "locator/cell_params.h"

#include <Eigen/Geometry>

namespace planar_bin_picking_ros {

struct DistanceRange {
  double min = 0.0, max = 0.0;  ///< metres
};

/// @param T_camera_bin  at the image's stamp
/// @throws Refusal  BAD_BIN: a corner lies beside or behind the camera, or the box reaches nearer,
///         farther or over a larger ratio of distances than parts can be looked for in
DistanceRange distanceRange(const CellParams& cell, const Eigen::Isometry3d& T_camera_bin);

}  // namespace planar_bin_picking_ros
