// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What is chosen by how well views are predicted that had no part in the solution: the robot's
/// noise, and the lens model.

#include "calibrate/hand_eye/bundle_adjustment.h"

namespace planar_bin_picking {

/// A solution and the views that it is made of.
struct HeldOut {
  const HandEyeProblem& problem;
  std::vector<const Observation*> views;
  AdjustOptions* options;
  Adjusted* state;
};

/// Errors of corners that the noise model does not know are easily taken for the robot's. Where
/// held-out views are surely predicted better with another robot noise, that one is right.
/// @return  mean over the views of the error as the other views predict it, with the robot poses as
/// reported; pixels
double chooseRobotNoise(HeldOut held_out);

/// Five coefficients, unless one or eight predict held-out pictures better by more than chance, the
/// boards placed freely.
/// @return  what was tried
std::vector<LensTrial> chooseLens(HeldOut held_out);

/// Why the lens of a solution cannot be used; "" where it can.
std::string lensError(const HandEyeProblem& problem, const Adjusted& state);

}  // namespace planar_bin_picking
