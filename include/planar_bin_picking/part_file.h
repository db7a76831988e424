// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part as its user describes it: a drawing, and optionally a few lines of YAML beside it.

#include "planar_bin_picking/drawing.h"

#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// Where the robot's tool goes, relative to the part.
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

/// Everything a user said about a part.
struct PartFile {
  std::string name;  ///< the stem of the file
  Drawing drawing;
  double thickness = 0.0;            ///< metres; 0 where unknown
  std::vector<PickPose> pick_poses;  ///< in order of preference
  PickTool tool;
  std::vector<std::string> warnings;  ///< about pick poses; those of the drawing stand in `drawing`
};

/// Reads `<name>.yaml` (keys: drawing, thickness_mm, keep_layers, skip_layers, print_layers,
/// pick_poses, tool_radius_mm, tool_height_mm) or a drawing alone. A drawing beside which a yaml of
/// the same stem lies is read with it.
/// @throws std::runtime_error  naming file, key, value and remedy (unknown keys are refused)
PartFile loadPartFile(const std::string& path);

}  // namespace planar_bin_picking
