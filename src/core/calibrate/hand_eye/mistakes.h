// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Names the common mistakes of input. Each mistake is undone as a trial; the closed-form solution
/// then fits the pictures, and without that does not.

#include "calibrate/hand_eye/closed_form.h"

namespace planar_bin_picking {

/// Whether each robot pose fits the picture before its own.
/// @param observations  in the order in which they were taken
/// @param pairs         of the same observations
bool areLateByOne(const HandEyeProblem& problem, const Intrinsics& intrinsics,
                  const HandEyeParams& params, const std::vector<Observation>& observations,
                  const std::vector<PosePair>& pairs);

/// What is wrong with the robot poses and what to change: the units, the direction, the mounting,
/// the order of the quaternion, the convention of the angles.
/// @return  "" where no such mistake explains the pictures
std::string nameMistake(const HandEyeProblem& problem, const Intrinsics& intrinsics,
                        const HandEyeParams& params);

/// Why the robot's turns do not determine the camera: views too much alike, a robot that turns
/// about one axis alone (and four_axis says nothing of it), or views that happen to; or turns that
/// four_axis denies. "" where they do determine it.
/// @param second_axis_deg  RMS turn about the second axis
std::string nameTurnFault(const std::vector<Observation>& observations, double second_axis_deg,
                          const HandEyeParams& params);

}  // namespace planar_bin_picking
