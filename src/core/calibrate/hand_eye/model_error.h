// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the noise model leaves out and the residuals show all the same. The covariance of a
/// solution takes every corner's error for independent of the others' and a given camera for exact.

#include "calibrate/hand_eye/normal_equations.h"

namespace planar_bin_picking {

/// The errors of one view may hang together (blur, light, a board that is not flat): then the views
/// pull at the solution more unevenly than independent corners do. Widens the covariance's blocks
/// (camera, hand-eye, board, scale) by the ratio of the two, measured over all views.
void widenByScatter(const Normals& normals, const AdjustOptions& options, Adjusted* state);

/// Where the pictures contradict the camera that is held fixed, adds to the covariance how far off
/// it seems to be, and what that does to all else. Sets camera_misfit.
void widenByGivenCamera(const HandEyeProblem& problem, const Normals& normals, Adjusted* state);

}  // namespace planar_bin_picking
