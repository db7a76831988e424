// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Drawn plates seen from several places, for the tests of the views.

#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/views/view.h"
#include "support/plates.h"

#include <random>

namespace planar_bin_picking {

/// The first camera carried about a point, and turned along: T_first_this.
inline Eigen::Isometry3d orbit(const Eigen::Vector3d& about_first, double angle_deg,
                               double axis_deg) {
  const Eigen::Vector3d axis(std::cos(axis_deg * kDegrees), std::sin(axis_deg * kDegrees), 0.0);
  return Eigen::Translation3d(about_first) * Eigen::AngleAxisd(angle_deg * kDegrees, axis) *
         Eigen::Translation3d(-about_first);
}

/// What the camera sees from there, of plates whose poses are those of the first view.
inline cv::Mat pictureFrom(const sim::PinholeCamera& camera, sim::Scene scene,
                           const Eigen::Isometry3d& T_first_this, int seed) {
  for (auto& plate : scene.plates)
    plate.T_camera_part = T_first_this.inverse() * plate.T_camera_part;
  scene.seed = seed;
  return sim::takeImage(camera, scene);
}

/// T * exp(xi) with this standard deviation per axis.
inline Eigen::Isometry3d shaken(const Eigen::Isometry3d& T, double metres, double degrees,
                                std::mt19937* random) {
  std::normal_distribution<double> normal;
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi(i) = (i < 3 ? metres : degrees * kDegrees) * normal(*random);
  return T * exp(xi);
}

}  // namespace planar_bin_picking
