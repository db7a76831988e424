// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the tables of calibration.cpp are made of: errors against the truth.

#include "calibrate/board/board_views.h"
#include "support/board_problem.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace planar_bin_picking {

struct Robot {
  double mm = 0.0, deg = 0.0;  ///< noise of a pose, per axis
};
inline const std::vector<Robot> kRobots = {{0.0, 0.0}, {0.1, 0.02}, {1.0, 0.1}};

inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

inline double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

struct PoseError {
  double mm = 0.0, deg = 0.0;
};

inline PoseError poseError(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth) {
  const Vector6d xi = log(estimate.inverse() * truth);
  return {1e3 * xi.head<3>().norm(), xi.tail<3>().norm() / sim::kDegree};
}

inline Camera::Model trueCamera(const sim::BoardCell& cell) {
  const sim::PinholeCamera& c = cell.camera;
  return {c.width, c.height, c.fx, c.fy, c.cx, c.cy, "plumb_bob", {c.lens.begin(), c.lens.end()}};
}

/// RMS error, in the mount's frame, of a small part that the calibrated camera measures without any
/// noise at its working distance, at five places in the image: what expected_error is to tell.
inline PoseError binError(const sim::BoardCell& cell, const HandEyeResult& result) {
  const double z = result.working_distance;
  const Camera camera(trueCamera(cell));
  const Board part{2, 2, 0.1 * z};
  double mm2 = 0.0, deg2 = 0.0;
  constexpr double kPlaces[][2] = {
      {0.5, 0.5}, {0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}};
  for (const auto& place : kPlaces) {
    const Eigen::Vector2d p =
        camera.undistort({place[0] * cell.camera.width, place[1] * cell.camera.height});
    const Eigen::Vector3d centre(z * p.x(), z * p.y(), z);
    const Eigen::Vector3d half(0.5 * part.square, 0.5 * part.square, 0.0);
    const Eigen::Isometry3d T_camera_board = rigid(Eigen::Matrix3d::Identity(), centre - half);
    std::vector<Eigen::Vector2d> corners;
    for (std::size_t i = 0; i < part.size(); ++i) {
      corners.push_back(project(cell.camera, T_camera_board * part.corner(i)));
    }
    Eigen::Isometry3d to_centre = Eigen::Isometry3d::Identity();
    to_centre.translation() = half;
    const PoseError error = poseError(
        result.T_mount_camera *
            boardPoseNear(result.camera, {part.points(), corners}, T_camera_board) * to_centre,
        cell.T_mount_camera * T_camera_board * to_centre);
    mm2 += error.mm * error.mm / 5.0;
    deg2 += error.deg * error.deg / 5.0;
  }
  return {std::sqrt(mm2), std::sqrt(deg2)};
}

/// Errors of many solutions, and how they compare with what was stated.
struct Errors {
  std::vector<double> mm, deg, fx_percent, by_sigma_mm, by_sigma_deg, by_expected_mm,
      by_expected_deg;

  void add(const sim::BoardCell& cell, const HandEyeResult& result) {
    const PoseError error = poseError(result.T_mount_camera, cell.T_mount_camera);
    const Matrix6d covariance = result.covariance.block<6, 6>(kHandEye, kHandEye);
    mm.push_back(error.mm);
    deg.push_back(error.deg);
    fx_percent.push_back(100.0 * std::abs(result.camera.fx / cell.camera.fx - 1.0));
    by_sigma_mm.push_back(1e-3 * error.mm / std::sqrt(covariance.topLeftCorner<3, 3>().trace()));
    by_sigma_deg.push_back(sim::kDegree * error.deg /
                           std::sqrt(covariance.bottomRightCorner<3, 3>().trace()));
    const PoseError bin = binError(cell, result);
    by_expected_mm.push_back(bin.mm / result.expected_error_mm);
    by_expected_deg.push_back(bin.deg / result.expected_error_deg);
  }
};

}  // namespace planar_bin_picking
