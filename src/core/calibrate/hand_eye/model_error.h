// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Tests of the noise model against the residuals. The covariance of a solution takes every
/// corner's error for independent of the others' and a given camera for exact; what the residuals
/// say against that widens it.

#include "calibrate/hand_eye/normal_equations.h"

namespace planar_bin_picking {

/// The errors of one view may be correlated (blur, light, a board that is not flat): then the
/// views' score vectors scatter more than independent corners allow. Scales the covariance's blocks
/// (camera; position and rotation of the hand-eye transform and of the board; scale) by the ratio
/// of the two over all views, as a sandwich estimator does with the views as its clusters. Position
/// and rotation by themselves, since what is correlated turns a board more than it shifts it; up
/// and down alike, since what is held at 1 from below states too much on average.
void scaleByScoreScatter(const Normals& normals, const AdjustOptions& options, Adjusted* state);

/// Where the pictures contradict the camera that is held fixed, adds to the covariance how far off
/// it seems to be, and what that does to all else. Sets camera_model_error.
void widenByGivenCamera(const HandEyeProblem& problem, const Normals& normals, Adjusted* state);

}  // namespace planar_bin_picking
