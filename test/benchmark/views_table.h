// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Errors of poses against the truth, and the rows of the tables of views.md.

#include "part/outline_view.h"
#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/part/part_model.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// Of one pose, in the first view's frame: along the line of sight and across it at the middle of
/// the visible face; the face's tilt and its turn within its plane.
struct PoseError {
  double depth_mm, lateral_mm, tilt_deg, turn_deg;
  /// Squared error over its variance, per dimension: depth, lateral, tilt, turn.
  std::array<double, 4> squared;
  /// What was expected of the error by the covariance: standard deviation of depth.
  double depth_sigma_mm;
};

/// The pose that looks the same and is nearest to the one that was found.
inline Eigen::Isometry3d nearestSame(const Eigen::Isometry3d& T_found,
                                     const Eigen::Isometry3d& T_first_true,
                                     const std::vector<Eigen::Isometry3d>& symmetric_poses,
                                     const Eigen::Isometry3d& T_part_centre) {
  Eigen::Isometry3d T_best = T_found;
  double least = 1e9;
  for (const Eigen::Isometry3d& same : symmetric_poses) {
    const Eigen::Isometry3d T = T_first_true * same * T_part_centre;
    const Eigen::Isometry3d between = T_found.inverse() * T;
    const double cost = between.translation().norm() + 0.1 * rotationAngle(between.linear());
    if (cost >= least) continue;
    least = cost;
    T_best = T;
  }
  return T_best;
}

template <int N>
double squaredOf(const Eigen::Matrix<double, N, 1>& error,
                 const Eigen::Matrix<double, N, N>& covariance) {
  return error.dot(covariance.ldlt().solve(error)) / N;
}

/// @param symmetric_poses  T_part_same: poses that look the same; the nearest is the truth
inline PoseError errorOf(const Detection& found, const PartModel& part,
                         const Eigen::Isometry3d& T_first_true,
                         const std::vector<Eigen::Isometry3d>& symmetric_poses) {
  const Eigen::Isometry3d T_part_centre = centreOf(part, found.face);
  const Eigen::Isometry3d T_found = found.T_camera_part * T_part_centre;
  const Eigen::Isometry3d T_true =
      nearestSame(T_found, T_first_true, symmetric_poses, T_part_centre);
  const Eigen::Vector3d ray = T_true.translation().normalized();
  Eigen::Matrix3d R_sight_first;  // two axes across the line of sight, then along it
  R_sight_first << ray.unitOrthogonal().transpose(), ray.cross(ray.unitOrthogonal()).transpose(),
      ray.transpose();
  const Vector6d off = log(T_found.inverse() * T_true);
  const Eigen::Matrix3d R = R_sight_first * T_found.linear();
  const Eigen::Vector3d at = R * off.head<3>();
  const Eigen::Matrix3d places = R * found.covariance.topLeftCorner<3, 3>() * R.transpose();
  const Matrix6d& C = found.covariance;
  PoseError out{};
  out.depth_mm = 1e3 * std::abs(at.z());
  out.lateral_mm = 1e3 * at.head<2>().norm();
  out.tilt_deg = off.segment<2>(3).norm() * 180.0 / M_PI;
  out.turn_deg = std::abs(off(5)) * 180.0 / M_PI;
  out.squared = {at.z() * at.z() / places(2, 2),
                 squaredOf<2>(at.head<2>(), places.topLeftCorner<2, 2>()),
                 squaredOf<2>(off.segment<2>(3), C.block<2, 2>(3, 3)), off(5) * off(5) / C(5, 5)};
  out.depth_sigma_mm = 1e3 * std::sqrt(places(2, 2));
  return out;
}

inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const auto i = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  return values[i];
}

template <class Get>
std::vector<double> valuesOf(const std::vector<PoseError>& errors, Get&& get) {
  std::vector<double> values;
  values.reserve(errors.size());
  for (const PoseError& e : errors) values.push_back(get(e));
  return values;
}

inline std::string cellOf(const std::vector<PoseError>& errors, double PoseError::*member) {
  const auto values = valuesOf(errors, [&](const PoseError& e) { return e.*member; });
  char text[80];
  std::snprintf(text, sizeof text, "%.2f / %.2f / %.2f", quantile(values, 0.5),
                quantile(values, 0.99), quantile(values, 1.0));
  return text;
}

/// Mean without the largest 1 %: a single wrong pose would say nothing of all the others.
inline double meanOfMost(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.resize(values.size() - values.size() / 100);
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

/// Median, 99 % and largest of each; the mean of the normalised squares; what depth was expected.
inline void printRow(const std::string& name, const std::vector<PoseError>& errors) {
  std::printf("| %s | %zu | %s | %s | %s |", name.c_str(), errors.size(),
              cellOf(errors, &PoseError::depth_mm).c_str(),
              cellOf(errors, &PoseError::tilt_deg).c_str(),
              cellOf(errors, &PoseError::lateral_mm).c_str());
  for (std::size_t i = 0; i < 4; ++i) {
    std::printf(" %.2f |",
                meanOfMost(valuesOf(errors, [&](const PoseError& e) { return e.squared[i]; })));
  }
  std::printf(" %.2f |\n",
              quantile(valuesOf(errors, [](const PoseError& e) { return e.depth_sigma_mm; }), 0.5));
}

}  // namespace planar_bin_picking
