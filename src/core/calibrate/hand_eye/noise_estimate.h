// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How noisy corners and robot are, from what is left over, and the covariance that follows.

#include "calibrate/hand_eye/normal_equations.h"

namespace planar_bin_picking {

/// Sets noise and weights from the residuals and corrections of a solution, and `degenerate` where
/// the covariance does not exist. Robot noise by MacKay's rule: the sum of the squared corrections
/// over the number of directions that the images determine better than the prior does.
void estimateNoise(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                   const AdjustOptions& options, Adjusted* state);

/// Sets covariance and `degenerate`.
void estimateCovariance(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                        const AdjustOptions& options, Adjusted* state);

}  // namespace planar_bin_picking
