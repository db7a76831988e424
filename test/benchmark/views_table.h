// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Errors of poses against the truth, and the rows of the table of views.

#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/part/part_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// Of one pose, in the first view's frame.
struct PoseError {
  double depth_mm, lateral_mm, tilt_deg;
  double squared;  ///< normalised by the covariance, per dimension
};

/// @param twins  T_part_twin: poses that look the same; the nearest is the truth
inline PoseError errorOf(const Detection& found, const PartModel& part,
                         const Eigen::Isometry3d& T_first_true,
                         const std::vector<Eigen::Isometry3d>& twins) {
  Eigen::Isometry3d T_part_centre = Eigen::Isometry3d::Identity();
  T_part_centre.translation() << part.center(), part.faceZ(found.face);
  const Eigen::Isometry3d T_found = found.T_camera_part * T_part_centre;
  double least = 1e9;
  Vector6d off = Vector6d::Zero();
  Eigen::Isometry3d T_best = T_found;
  for (const Eigen::Isometry3d& twin : twins) {
    const Eigen::Isometry3d T = T_first_true * twin * T_part_centre;
    const Eigen::Isometry3d between = T_found.inverse() * T;
    const double cost = between.translation().norm() + 0.1 * rotationAngle(between.linear());
    if (cost >= least) continue;
    least = cost;
    off = log(between);
    T_best = T;
  }
  const Eigen::Vector3d ray = T_best.translation().normalized();
  const Eigen::Vector3d d = T_found.translation() - T_best.translation();
  const double depth = d.dot(ray);
  const double tilt =
      std::acos(std::min(1.0, std::abs(T_found.linear().col(2).dot(T_best.linear().col(2)))));
  return {1e3 * std::abs(depth), 1e3 * (d - depth * ray).norm(), tilt * 180.0 / M_PI,
          off.dot(found.covariance.ldlt().solve(off)) / 6.0};
}

inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const auto i = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  return values[i];
}

inline std::string cellOf(const std::vector<PoseError>& errors, double PoseError::*member) {
  std::vector<double> values;
  for (const PoseError& e : errors) values.push_back(e.*member);
  char text[80];
  std::snprintf(text, sizeof text, "%.2f / %.2f / %.2f", quantile(values, 0.5),
                quantile(values, 0.99), quantile(values, 1.0));
  return text;
}

/// Median, 99 % and largest of each; the mean of the normalised squares without their upper 1 %.
inline void printRow(const std::string& name, const std::vector<PoseError>& errors) {
  std::vector<double> squares;
  for (const PoseError& e : errors) squares.push_back(e.squared);
  std::sort(squares.begin(), squares.end());
  double sum = 0.0;
  const std::size_t kept = squares.size() - squares.size() / 100;
  for (std::size_t i = 0; i < kept; ++i) sum += squares[i];
  std::printf("| %s | %zu | %s | %s | %s | %.2f |\n", name.c_str(), errors.size(),
              cellOf(errors, &PoseError::depth_mm).c_str(),
              cellOf(errors, &PoseError::tilt_deg).c_str(),
              cellOf(errors, &PoseError::lateral_mm).c_str(),
              kept > 0 ? sum / static_cast<double>(kept) : 0.0);
}

}  // namespace planar_bin_picking
