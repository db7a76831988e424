// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the poses of a picture tell about one another, where no plane is known (plane_prior.h).
///
/// Plates rest on one another and on one floor. Tilt and depth are what a picture tells worst;
/// where it leaves them open, the way that the other parts lie is likely, and the more so the more
/// alike these lie (an empirical Bayes estimate): in a single layer both are told well, in a heap
/// the depth not at all. A pose that clearly lies otherwise is left alone: a few parts lean on
/// others or on the wall. No pose has a say in its own prior.

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
  /// @param poses   their covariances are about the centres of the visible faces
  /// @param weights of the poses, 0..1: the probability that the tilt has the right sign; empty =
  ///                all 1
  SceneFaces(const std::vector<RefinedPose>& poses,
             const std::vector<std::shared_ptr<const PartModel>>& parts,
             const std::vector<double>& weights = {});

  /// @param left_out  index of the pose that is left out; nothing where all count
  /// @return          nothing where the poses are too few to tell
  /// Cost: O(poses).
  std::optional<ScenePlane> plane(std::optional<std::size_t> left_out = std::nullopt) const;

 private:
  struct Face {
    Eigen::Vector3d normal_camera, centre_camera;
    double thickness, tilt_variance;
    Eigen::Matrix3d centre_covariance;  // camera axes
    double weight;
  };
  std::vector<Face> faces_;
};

/// Logarithm of the density, but for a constant, with which a part of the scene has this normal: it
/// lies as most do, or, one in ten, anyhow.
/// @param variance  of the measured normal, rad^2 per axis
double logTiltDensity(const ScenePlane& scene, const Eigen::Vector3d& normal_camera,
                      double variance);

/// Each pose with the plane of the others as its prior; nothing changes where these are too few.
/// Cost: O(poses^2), 0.1 ms for 40.
void fuseWithScenePlane(const std::vector<std::shared_ptr<const PartModel>>& parts,
                        std::vector<RefinedPose>* poses);

}  // namespace planar_bin_picking
