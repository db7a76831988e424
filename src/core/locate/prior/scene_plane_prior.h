// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Between refinement and score, where no plane is known (plane_prior.h): what the poses of a
/// picture tell about one another.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_model.h"

#include <memory>
#include <optional>
#include <vector>

namespace planar_bin_picking {

/// How most parts lie: plates rest on one another and on one floor.
struct CommonLie {
  Eigen::Vector3d normal_camera;  ///< of the faces, unit, toward the camera
  double tilt_spread;             ///< standard deviation of a face's normal about it, rad per axis
  double height;                  ///< of the undersides along the normal, metres from the camera
  double height_spread;           ///< standard deviation of an underside about it, metres
  /// How well normal and height are known themselves: rad per axis, metres at the middle.
  double tilt_sigma, height_sigma;
  Eigen::Vector3d middle_camera;  ///< of the parts, metres
};

/// @return  nothing where the poses are too few to tell
std::optional<CommonLie> commonLie(const std::vector<RefinedPose>& poses,
                                   const std::vector<std::shared_ptr<const PartModel>>& parts);

/// Tilt and depth are what a picture tells worst; where it leaves them open, the way that the other
/// parts lie is likely, and the more so the more alike these lie (an empirical Bayes estimate): in
/// a single layer both are told well, in a heap the depth not at all. A pose that clearly lies
/// otherwise is left alone: a few parts lean on others or on the wall.
void fuseWithCommonLie(const CommonLie& lie,
                       const std::vector<std::shared_ptr<const PartModel>>& parts,
                       std::vector<RefinedPose>* poses);

}  // namespace planar_bin_picking
