// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/scene_normals.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = EIGEN_PI / 180.0;

/// By how much two parts that lie alike differ (burrs, a floor that is not flat), per axis.
constexpr double kAlike = 1.0 * kRadians;
/// How parts lie that lie as no other: about the mean normal, per axis; so many parts of a scene do
/// at least, as before anything is seen.
constexpr double kOutlying = 15.0 * kRadians, kOutlyingParts = 1.0;

double density(double off2, double variance) { return std::exp(-0.5 * off2 / variance) / variance; }

}  // namespace

double logTiltDensity(const std::vector<SceneNormal>& scene, const Eigen::Vector3d& normal_camera,
                      double variance, std::size_t left_out) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double sum = 0.0;
  for (const SceneNormal& other : scene) {
    if (other.part == left_out) continue;
    const double off2 = (other.normal_camera - normal_camera).squaredNorm();
    sum += other.probability * density(off2, variance + other.variance + kAlike * kAlike);
    mean += other.probability * other.normal_camera;
  }
  if (mean.isZero(0.0)) return 0.0;
  const double off2 = (mean.normalized() - normal_camera).squaredNorm();
  return std::log(sum + kOutlyingParts * density(off2, variance + kOutlying * kOutlying));
}

}  // namespace planar_bin_picking
