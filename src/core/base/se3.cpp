// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/base/se3.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {

Eigen::Isometry3d exp(const Vector6d& xi) {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  expSe3<double>(xi, &R, &t);
  return rigid(R, t);
}

Vector6d log(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d w = rotationVector(T.linear());
  const double angle = w.norm();
  const Eigen::Matrix3d W = skew<double>(w);
  // 1/a^2 - (1 + cos a) / (2 a sin a), by its series where a is small.
  double d = 1.0 / 12.0 + angle * angle / 720.0;
  if (angle > 1e-3) {
    d = 1.0 / (angle * angle) - 0.5 / (angle * std::tan(0.5 * angle));
  }
  Vector6d xi;
  xi << T.translation() - 0.5 * (W * T.translation()) + d * (W * (W * T.translation())), w;
  return xi;
}

Eigen::Quaterniond quaternionOf(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  return q;
}

Eigen::Vector3d rotationVector(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q = quaternionOf(R);
  const double s = q.vec().norm();
  if (s < 1e-12) return 2.0 * q.vec();
  return 2.0 * std::atan2(s, q.w()) / s * q.vec();
}

double rotationAngle(const Eigen::Matrix3d& R) { return rotationVector(R).norm(); }

Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  if (R.determinant() < 0.0) {
    Eigen::Matrix3d U = svd.matrixU();
    U.col(2) *= -1.0;
    R = U * svd.matrixV().transpose();
  }
  return R;
}

Eigen::Isometry3d rigid(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

}  // namespace planar_bin_picking
