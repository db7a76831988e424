// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The plane that most parts of a picture lie on, as a prior on each pose, where no plane is known
/// (plane_prior.h).
///
/// Plates rest on one another and on one floor. A picture determines tilt and depth worst. Where it
/// leaves them open, a part most likely lies as the others do, and the more so the more alike these
/// lie (an empirical Bayes estimate): in a single layer the prior determines both well, in a heap
/// not the depth. A pose that clearly lies otherwise is hardly changed: a few parts lean on others
/// or on the wall. The prior of a pose is estimated without that pose.

#include "planar_bin_picking/part/part_model.h"

#include <memory>
#include <optional>
#include <vector>

namespace planar_bin_picking {

/// The plane of the undersides of most parts of a scene.
struct ScenePlane {
  Plane plane;
  double tilt_spread;    ///< standard deviation of a face's normal about the plane's, rad per axis
  double height_spread;  ///< standard deviation of an underside about the plane, metres
  /// How well the plane itself is known: rad per axis, metres at the middle.
  double tilt_sigma, height_sigma;
  Eigen::Vector3d middle_camera;  ///< of the parts, metres
};

/// The faces of a scene, kept so that the plane can be estimated without one of them.
class SceneFaces {
 public:
  /// @param poses  their covariances are about the centres of the visible faces
  SceneFaces(const std::vector<RefinedPose>& poses,
             const std::vector<std::shared_ptr<const PartModel>>& parts);

  /// @param left_out  index of the pose that is left out; nothing where all count
  /// @return          nothing where the poses are too few to tell
  /// Cost: O(poses).
  std::optional<ScenePlane> plane(std::optional<std::size_t> left_out = std::nullopt) const;

 private:
  struct Face {
    Eigen::Vector3d normal_camera, centre_camera;
    double thickness, tilt_variance;
    Eigen::Matrix3d centre_covariance;  // camera axes
  };
  std::vector<Face> faces_;
};

/// Each pose with the plane of the others as its prior; nothing changes where these are too few.
/// Cost: O(poses^2), 0.1 ms for 40.
void fuseWithScenePlane(const std::vector<std::shared_ptr<const PartModel>>& parts,
                        std::vector<RefinedPose>* poses);

}  // namespace planar_bin_picking
