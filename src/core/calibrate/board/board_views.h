// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// From a board's corners in pictures to where the board was, and to a first camera.

#include "planar_bin_picking/calibrate/board/board.h"
#include "planar_bin_picking/image/camera.h"

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace planar_bin_picking {

/// Corners of a board in one picture.
struct SeenPoints {
  std::vector<Eigen::Vector3d> points;   ///< in the frame `board`
  std::vector<Eigen::Vector2d> corners;  ///< pixels, one each
};

/// Focal length and k1 from the corners alone, the rest as a camera has it.
/// @param views  at least one
Camera::Model cameraFromBoards(const std::vector<SeenPoints>& views, int width, int height);

/// The board's pose that fits corners best; nothing where none does.
std::optional<Eigen::Isometry3d> boardPose(const Camera::Model& camera, const SeenPoints& view);

/// The same, from a pose nearby.
Eigen::Isometry3d boardPoseNear(const Camera::Model& camera, const SeenPoints& view,
                                const Eigen::Isometry3d& T_camera_board);

}  // namespace planar_bin_picking
