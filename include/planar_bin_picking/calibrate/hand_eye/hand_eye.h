// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Robot poses + board corners -> intrinsics, lens distortion, and where the camera sits, with a
/// verdict.
///
/// Eye-in-hand:  x_camera = T_flange_camera^-1 * (T_base_flange * exp(c))^-1 * T_base_board *
/// x_board Eye-to-hand:  x_camera = T_base_camera^-1 * T_base_flange * exp(c) * T_flange_board *
/// x_board
///
/// All of it is estimated at once by minimising reprojection errors. c is a small correction of
/// each robot pose, held near zero by the robot's own accuracy, which is estimated from the data
/// unless it is given: without it a robot that is a millimetre off pulls the camera to wherever the
/// errors fit best, and the stated uncertainty is far too small.
///
/// References: Tsai and Lenz 1989, Park and Martin 1994, Horaud and Dornaika 1995, Andreff et al.
/// 1999, Daniilidis 1999 (all as OpenCV has them), and MacKay 1992, Bayesian interpolation, for the
/// variances.

#include "planar_bin_picking/calibrate/hand_eye/hand_eye_problem.h"

namespace planar_bin_picking {

/// Solves and judges. Deterministic. Degenerate input is an answer (REFUSED with reasons), not an
/// error.
/// @throws std::invalid_argument  bad board, image size, camera, params; an observation with
/// another number of
///         corners than the board, or with anything not finite: which one
/// Cost: about 0.2 s for 15 views of 9 x 6 corners; see test/benchmark/calibration.md.
HandEyeResult solveHandEye(const HandEyeProblem& problem, const HandEyeParams& params);

}  // namespace planar_bin_picking
