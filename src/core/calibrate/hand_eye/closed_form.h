// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Robot poses and board poses side by side: which way round each board was seen, which pairs are
/// wrong, about which axes the robot turned, and the closed-form solutions that the bundle
/// adjustment starts from.

#include "calibrate/hand_eye/chain.h"

namespace planar_bin_picking {

/// Robot and board side by side: G_i * G_j^-1 * X = X * C_i * C_j^-1 for all views i and j, where X
/// is T_mount_camera, C is T_camera_board and G is T_flange_base for a camera in the hand,
/// T_base_flange for one outside.
struct PosePair {
  Eigen::Isometry3d robot;  ///< G
  Eigen::Isometry3d board;  ///< C
};

Eigen::Isometry3d robotSide(Mounting mounting, const Eigen::Isometry3d& T_base_flange);

/// Which ordering (index into orderings(board)) each view's corners must be brought into so that
/// the board turns by the same angles as the robot.
std::vector<std::size_t> chooseOrderings(const std::vector<PosePair>& motions, const Board& board);

/// Corners in another order.
std::vector<Eigen::Vector2d> reordered(const std::vector<Eigen::Vector2d>& corners,
                                       const std::vector<std::size_t>& ordering);

/// Median difference between the robot's and the board's angle over the pairs of each view,
/// radians.
std::vector<double> angleErrors(const std::vector<PosePair>& motions);

/// RMS rotation of the robot about the second most used axis, radians; 0 with fewer than two pairs.
double secondAxis(const std::vector<PosePair>& motions, const HandEyeParams& params);

/// Closed forms: for robots that turn about z alone their own; for others OpenCV's five and one
/// over the pairs of useful angle; Tsai's needs no such choice.
/// @param free_scale  estimate the board's scale, too (own form alone)
/// @return  chains without corrections, those that came out finite
std::vector<Chain> closedForms(const HandEyeProblem& problem, const std::vector<PosePair>& motions,
                               const Intrinsics& intrinsics, const HandEyeParams& params,
                               bool free_scale);

}  // namespace planar_bin_picking
