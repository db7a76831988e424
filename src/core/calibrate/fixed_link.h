// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A fixed transform between two frames, in the forms that other programs read.

#include <Eigen/Geometry>

#include <string>

namespace planar_bin_picking {

struct FixedLink {
  std::string parent, child;  ///< frames
  Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();
  std::string comment;  ///< one line, of what it was made
};

/// A launch file that puts it on tf.
std::string staticTransformLaunch(const FixedLink& link);

/// A joint of a robot's description between links that it has; rpy turns about fixed x, y, z.
std::string handEyeXacro(const FixedLink& link);

}  // namespace planar_bin_picking
