// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A cell's bin as the camera sees it: how near and how far it reaches, and how much lies in it.

#include "locator/answer/answer.h"
#include "locator/settings/cell_params.h"
#include "planar_bin_picking/bin/floor_cover.h"

#include <Eigen/Geometry>

namespace planar_bin_picking_ros {

struct DistanceRange {
  double min = 0.0, max = 0.0;  ///< metres
};

/// @param T_camera_bin  at the image's stamp
/// @throws Refusal  BAD_BIN: a corner lies beside or behind the camera, or the box reaches nearer,
///         farther or over a larger ratio of distances than parts can be looked for in
DistanceRange distanceRange(const CellParams& cell, const Eigen::Isometry3d& T_camera_bin);

/// How much of the bin's floor is covered in the picture of an answer, by whatever it is.
/// @param answer  with all that was found in it
planar_bin_picking::FloorCover lookIntoBin(const CellParams& cell,
                                           const Eigen::Isometry3d& T_camera_bin,
                                           const Answer& answer);

}  // namespace planar_bin_picking_ros
