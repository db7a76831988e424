// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planar_bin_picking/base/types.h"

#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {

/// The two planes that look like the affine map `A` (part x, y in metres -> ideal image plane) at
/// the ideal image point `p`: the infinitesimal plane-based pose of [4]. They differ in the sign of
/// the tilt about the viewing ray and coincide where nothing is foreshortened.
/// @return  T_camera_plane, x and y of the plane as in A, origin at the point seen at p
inline std::array<Eigen::Isometry3d, 2> posesFromAffine(const Eigen::Matrix2d& A,
                                                        const Eigen::Vector2d& p) {
  const Eigen::Vector3d ray = p.homogeneous().normalized();
  const Eigen::Matrix3d R_camera_ray =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray).toRotationMatrix();
  Eigen::Matrix<double, 2, 3> project;  // of a displacement at unit depth
  project << 1, 0, -p.x(), 0, 1, -p.y();
  const Eigen::Matrix2d M = (project * R_camera_ray).leftCols<2>().inverse() * A;
  const double depth = 1.0 / Eigen::JacobiSVD<Eigen::Matrix2d>(M).singularValues()(0);
  const Eigen::Matrix2d Q = depth * M;
  // Columns of a rotation have length 1 and are perpendicular: their missing third row follows.
  const Eigen::Matrix2d rest = Eigen::Matrix2d::Identity() - Q.transpose() * Q;
  const double c0 = std::sqrt(std::max(0.0, rest(0, 0)));
  const double c1 = std::copysign(std::sqrt(std::max(0.0, rest(1, 1))), rest(0, 1));
  std::array<Eigen::Isometry3d, 2> out;
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? 1.0 : -1.0;
    Eigen::Matrix3d R;
    R.col(0) << Q.col(0), sign * c0;
    R.col(1) << Q.col(1), sign * c1;
    R.col(0).normalize();
    R.col(1) = (R.col(1) - R.col(0) * R.col(0).dot(R.col(1))).normalized();
    R.col(2) = R.col(0).cross(R.col(1));
    out[k] = Eigen::Isometry3d::Identity();
    out[k].linear() = R_camera_ray * R;
    out[k].translation() = depth * p.homogeneous();
  }
  return out;
}

}  // namespace planar_bin_picking
