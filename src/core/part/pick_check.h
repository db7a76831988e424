// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a pick pose can be what its user meant: a sign or a unit that is wrong sends the tool
/// the wrong way.

#include "planar_bin_picking/drawing/drawing.h"
#include "planar_bin_picking/part/pick_poses.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

/// A word without @ and /, which set apart a copy's number and the pose's frame on tf.
bool isPickName(const std::string& name);
inline constexpr char kPickNameExpected[] = "a word without @ and /";

/// @return  what is wrong with the pose's z, and the remedy; empty where it points into the part
///          for every face that the pose applies to
std::string wrongDirection(const PickPose& pose);

/// @param thickness  of the part, metres; 0 where unknown
/// @return  about poses that touch nothing but air, or more than the part has there, or whose
///          direction is wrong
std::vector<std::string> pickWarnings(const std::vector<PickPose>& poses, const PickTool& tool,
                                      const Drawing& drawing, double thickness);

}  // namespace planar_bin_picking
