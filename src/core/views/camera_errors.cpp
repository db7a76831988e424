// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "views/camera_errors.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

/// What a view's edges are off all alike, because light falls on broken edges from one side: as far
/// as one view's edge offset is from another's (joint_pose.cpp). It shows as a camera that is
/// shifted by as much, however many pixels the picture has.
constexpr double kLeastMetres = 0.03e-3;
/// And by blur and noise, as one that is turned by a part of a pixel.
constexpr double kLeastPx = 0.05;

Matrix6d squares(double metres, double degrees, double least_metres, double least_radians) {
  const double radians = degrees * EIGEN_PI / 180.0;
  Vector6d out;
  out.head<3>().setConstant(metres * metres + least_metres * least_metres);
  out.tail<3>().setConstant(radians * radians + least_radians * least_radians);
  return out.asDiagonal();
}

}  // namespace

Matrix6d adjoint(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  Matrix6d out = Matrix6d::Zero();
  out.topLeftCorner<3, 3>() = out.bottomRightCorner<3, 3>() = R;
  out.topRightCorner<3, 3>() = skew<double>(T.translation()) * R;
  return out;
}

Eigen::MatrixXd correctionCovariance(const std::vector<Eigen::Isometry3d>& T_first_view,
                                     const ViewsParams& params, double focal_px) {
  const auto n = static_cast<Eigen::Index>(T_first_view.size());
  const Matrix6d robot =
      squares(params.robot_sigma, params.robot_sigma_deg, kLeastMetres, kLeastPx / focal_px);
  const Matrix6d hand_eye = squares(params.hand_eye_sigma, params.hand_eye_sigma_deg, 0.0, 0.0);
  // c = (1 - Ad(T^-1)) x - Ad(T^-1) e_first + e_view, to first order.
  Eigen::MatrixXd by_hand_eye(6 * n, 6), by_first(6 * n, 6);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Matrix6d back = adjoint(T_first_view[static_cast<std::size_t>(k)].inverse());
    by_hand_eye.middleRows<6>(6 * k) = Matrix6d::Identity() - back;
    by_first.middleRows<6>(6 * k) = -back;
  }
  Eigen::MatrixXd out =
      by_hand_eye * hand_eye * by_hand_eye.transpose() + by_first * robot * by_first.transpose();
  for (Eigen::Index k = 0; k < n; ++k) out.block<6, 6>(6 * k, 6 * k) += robot;
  return out;
}

}  // namespace planar_bin_picking
