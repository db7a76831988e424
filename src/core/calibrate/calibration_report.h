// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

#include <string>

namespace planar_bin_picking {

/// One page for people: verdict, numbers beside their limits, residuals, uncertainty over the
/// image, poses, views, pictures. HTML with drawings in it; needs nothing else but the pictures.
/// @param made      of which camera and when, for its heading
/// @param pictures  goes in front of the views' names
std::string calibrationReport(const HandEyeProblem& problem, const HandEyeResult& result,
                              const std::string& made = "", const std::string& pictures = "");

}  // namespace planar_bin_picking
