// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common_lie.h"

#include "outline_view.h"
#include "planar_bin_picking/se3.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = EIGEN_PI / 180.0;

/// Of the visible face, toward the camera.
Eigen::Vector3d normalOf(const RefinedPose& pose) {
  return pose.T_camera_part.linear().col(2) * (pose.face == Face::kFront ? 1.0 : -1.0);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// Of the two tilts, per axis.
double tiltVariance(const RefinedPose& pose) {
  return 0.5 * (pose.covariance(3, 3) + pose.covariance(4, 4));
}

/// Variance of the tilts that others like this one have, by how far it is off: a few lie anyhow.
double spreadAt(double off2, double measured, double spread) {
  constexpr double kAnyhow = 15.0 * kRadians, kShareAnyhow = 0.1;
  const auto density = [&](double variance) { return std::exp(-0.5 * off2 / variance) / variance; };
  const double alike = measured + spread * spread, anyhow = measured + kAnyhow * kAnyhow;
  return (1.0 - kShareAnyhow) * density(alike) > kShareAnyhow * density(anyhow) ? spread * spread
                                                                                : kAnyhow * kAnyhow;
}

}  // namespace

std::optional<CommonLie> commonLie(const std::vector<RefinedPose>& poses) {
  constexpr std::size_t kFew = 6;
  constexpr double kLeast = 0.2 * kRadians;
  constexpr double kToVariance = 1.0 / 1.386;  // of two Gaussians' median sum of squares
  if (poses.size() < kFew) return std::nullopt;
  CommonLie lie;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto& p : poses) values.push_back(normalOf(p)(axis));
    lie.normal_camera(axis) = median(values);
  }
  lie.normal_camera.normalize();
  std::vector<double> squares, measured;
  for (const auto& p : poses) {
    squares.push_back((normalOf(p) - lie.normal_camera).squaredNorm());
    measured.push_back(tiltVariance(p));
  }
  lie.spread =
      std::sqrt(std::max(kLeast * kLeast, kToVariance * median(squares) - median(measured)));
  return lie;
}

void fuseWithCommonLie(const CommonLie& lie,
                       const std::vector<std::shared_ptr<const PartModel>>& parts,
                       std::vector<RefinedPose>* poses) {
  for (auto& p : *poses) {
    const Eigen::Isometry3d T_part_centre = centreOf(*parts[p.part], p.face);
    const Eigen::Isometry3d T_camera_centre = p.T_camera_part * T_part_centre;
    const double up = p.face == Face::kFront ? 1.0 : -1.0;
    // The common normal along the part's x and y: zero where the part lies along it.
    const Eigen::Vector3d n = up * T_camera_centre.linear().transpose() * lie.normal_camera;
    const Eigen::Vector2d off = n.head<2>();
    Eigen::Matrix<double, 2, 6> J = Eigen::Matrix<double, 2, 6>::Zero();
    J.rightCols<3>() = skew(n).topRows<2>();  // a turn w of the part takes n to n - w x n
    const Eigen::Matrix2d measured = J * p.covariance * J.transpose();
    const double spread2 = spreadAt(off.squaredNorm(), 0.5 * measured.trace(), lie.spread);
    const Eigen::Matrix2d sum = measured + spread2 * Eigen::Matrix2d::Identity();
    const Eigen::Matrix<double, 6, 2> gain = sum.ldlt().solve(J * p.covariance).transpose();
    const Vector6d xi = -gain * off;
    p.T_camera_part = T_camera_centre * exp(xi) * T_part_centre.inverse();
    const Matrix6d left = p.covariance - gain * J * p.covariance;
    p.covariance = 0.5 * (left + left.transpose());
  }
}

}  // namespace planar_bin_picking
