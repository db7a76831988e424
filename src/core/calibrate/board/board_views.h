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

/// Focal length and k1 from the corners alone, the rest as a camera has it.
/// @param views  the corners of each picture, at least one
Camera::Model cameraFromBoards(const Board& board,
                               const std::vector<std::vector<Eigen::Vector2d>>& views, int width,
                               int height);

/// The board's pose that fits corners best; nothing where none does.
std::optional<Eigen::Isometry3d> boardPose(const Camera::Model& camera, const Board& board,
                                           const std::vector<Eigen::Vector2d>& corners);

/// The same, from a pose nearby.
Eigen::Isometry3d boardPoseNear(const Camera::Model& camera, const Board& board,
                                const std::vector<Eigen::Vector2d>& corners,
                                const Eigen::Isometry3d& T_camera_board);

}  // namespace planar_bin_picking
