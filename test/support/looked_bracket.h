// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One drawn bracket that several views look at, for the tests of the views.

#include "support/orbit.h"

#include <memory>

namespace planar_bin_picking {

inline const sim::PinholeCamera kPinhole;
inline const sim::Lie kLie{20, -10, 600, 30, 12, 60};
inline const auto kBracket = makePart("bracket", bracketPlate());
/// Of its outline, in the first view's frame.
inline const Eigen::Vector3d kCentre = sim::poseOf(kLie) * Eigen::Vector3d(0.007, -0.004, 0.0);

/// With all edges so much farther in the material.
inline sim::Plate smallerBracket(double mm) {
  const sim::Plate drawn = bracketPlate();
  sim::Plate plate{{}, {circle(-18, 6, 6 + mm, true), circle(32, -19, 4 + mm, true)}, {}, 0.0};
  const double x[] = {mm, -mm, -mm, -mm, -mm, mm}, y[] = {mm, mm, -mm, -mm, -mm, -mm};
  for (std::size_t i = 0; i < drawn.outer.size(); ++i)
    plate.outer.push_back({drawn.outer[i].x() + x[i], drawn.outer[i].y() + y[i]});
  return plate;
}

inline sim::Scene bracketAt(const Eigen::Isometry3d& T_first_part) {
  sim::Scene scene = sceneOf(bracketPlate(), kLie);
  scene.plates[0].T_camera_part = T_first_part;
  return scene;
}

/// @param T_said  where the camera is said to be, if not where it is
inline ViewPtr viewOf(const sim::Scene& scene, const Eigen::Isometry3d& T_first_this, int seed,
                      const Eigen::Isometry3d* T_said = nullptr) {
  return std::make_shared<const View>(pictureFrom(kPinhole, scene, T_first_this, seed),
                                      makeCamera(kPinhole), T_said ? *T_said : T_first_this);
}

/// As the first view tells it alone.
inline Detection knownAt(const Eigen::Isometry3d& T_first_part) {
  Detection known;
  known.T_camera_part = T_first_part;
  known.face = faceOf(T_first_part);
  known.score = 0.9;
  known.covariance.diagonal() << 1e-8, 1e-8, 1e-6, 1e-4, 1e-4, 1e-6;
  return known;
}

}  // namespace planar_bin_picking
