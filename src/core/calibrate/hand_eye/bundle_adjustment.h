// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Bundle adjustment over everything at once, and what is known afterwards.

#include "calibrate/hand_eye/normal_equations.h"

namespace planar_bin_picking {

/// Starts from `start` and the noise in it, weights corners robustly, re-estimates the noise.
/// @param views  pointers to usable observations
Adjusted adjust(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                const Adjusted& start, const AdjustOptions& options);

/// A start without corrections.
Adjusted startAt(const Chain& chain, const Noise& noise,
                 const std::vector<const Observation*>& views);

}  // namespace planar_bin_picking
