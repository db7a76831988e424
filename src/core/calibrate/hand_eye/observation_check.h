// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Observations that say by themselves that something is wrong, before anything is solved.

#include "calibrate/hand_eye/closed_form.h"
#include "calibrate/hand_eye/verdict.h"

namespace planar_bin_picking {

/// An observation that may be used: its corners in the order that all views share.
struct Usable {
  std::size_t index = 0;  ///< in the problem
  Observation observation;
  PosePair poses;
};

/// Sorts out orderings, repeated views, wrong pairs and stale robot poses; says in `views` what
/// became of each.
std::vector<Usable> checkObservations(const HandEyeProblem& problem, const HandEyeParams& params,
                                      const Intrinsics& intrinsics, std::vector<ViewResult>* views,
                                      Findings* findings);

}  // namespace planar_bin_picking
