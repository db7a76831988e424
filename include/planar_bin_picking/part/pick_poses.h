// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part's pick poses with the copies that its symmetry makes of them: where a part looks the same
/// after a turn, the tool can go there, too.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/drawing/symmetry.h"

#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// Where the robot's tool goes, relative to the part; its z points into the part.
struct PickPose {
  std::string name;
  FaceFilter face = FaceFilter::kAny;  ///< the face that must be up for it
  Eigen::Isometry3d T_part_pick = Eigen::Isometry3d::Identity();
  bool symmetric = true;  ///< where the part looks the same after a turn, it can go there, too
};

/// The tool that picks a part, as a cylinder about the pick pose's z. Where nothing is said,
/// PickParams says it.
struct PickTool {
  std::optional<double> radius;  ///< metres
  std::optional<double> height;  ///< metres over the contact; what is above it is free; 0 = no end
};

/// Turns about the centre, and of a part that equals its mirror image also turns upside down: these
/// copies are for the other face. Copies are named after their pose: "web", "web@2", "web@3" …
/// @param thickness  metres; upside down, a part lies on its other face
/// @return  in order of preference: each pose as given, then its copies, those for its own face
///          first; at most 12 turns of each, evenly spread. A pose with symmetric = false has no
///          copies, and none is made where a pose stands already.
std::vector<PickPose> withSymmetricCopies(const std::vector<PickPose>& poses,
                                          const Symmetry& symmetry, double thickness);

}  // namespace planar_bin_picking
