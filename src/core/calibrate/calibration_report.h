// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

#include <string>

namespace planar_bin_picking {

/// One page for people: verdict, numbers, residuals, coverage of the image, poses, views. HTML with
/// drawings in it; needs nothing else.
/// @param made  of which camera and when, for its heading
std::string calibrationReport(const HandEyeProblem& problem, const HandEyeResult& result,
                              const std::string& made = "");

}  // namespace planar_bin_picking
