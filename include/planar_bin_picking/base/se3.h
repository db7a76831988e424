// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Small motions. The one statement of the convention: perturbations act on the right,
///
///     T <- T * exp(xi),   xi = [translation; rotation]   (metres, radians),
///
/// and every 6-vector and 6x6 covariance of the core has that order. exp is the exponential map of
/// SE(3), that is, the translation is turned along with the rotation.

#include "planar_bin_picking/base/types.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace planar_bin_picking {

/// The matrix of v: skew(v) * x = v cross x.
template <class T>
Eigen::Matrix<T, 3, 3> skew(const Eigen::Matrix<T, 3, 1>& v) {
  Eigen::Matrix<T, 3, 3> m;
  m << T(0), -v.z(), v.y(), v.z(), T(0), -v.x(), -v.y(), v.x(), T(0);
  return m;
}

/// exp(xi) as rotation and translation; also for automatic derivatives (hence the template), which
/// are right at xi = 0, too.
template <class T>
void expSe3(const Eigen::Matrix<T, 6, 1>& xi, Eigen::Matrix<T, 3, 3>* R,
            Eigen::Matrix<T, 3, 1>* t) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const Eigen::Matrix<T, 3, 1> v = xi.template head<3>(), w = xi.template tail<3>();
  const Eigen::Matrix<T, 3, 3> W = skew<T>(w);
  const Eigen::Matrix<T, 3, 3> W2 = W * W;
  const T angle2 = w.squaredNorm();
  // sin(a)/a, (1 - cos(a))/a^2, (a - sin(a))/a^3, by their series where a is small.
  T a = T(1) - angle2 / T(6), b = T(0.5) - angle2 / T(24), c = T(1.0 / 6) - angle2 / T(120);
  if (angle2 > T(1e-8)) {
    const T angle = sqrt(angle2);
    a = sin(angle) / angle;
    b = (T(1) - cos(angle)) / angle2;
    c = (T(1) - a) / angle2;
  }
  *R = Eigen::Matrix<T, 3, 3>::Identity() + a * W + b * W2;
  *t = v + b * (W * v) + c * (W2 * v);
}

Eigen::Isometry3d exp(const Vector6d& xi);

/// The inverse of exp; rotations by less than 180 degrees.
Vector6d log(const Eigen::Isometry3d& T);

/// Of its two quaternions the one whose w is not negative.
Eigen::Quaterniond quaternionOf(const Eigen::Matrix3d& R);

/// Rotation vector of a rotation, at most 180 degrees long.
Eigen::Vector3d rotationVector(const Eigen::Matrix3d& R);

/// Angle of a rotation, 0 .. pi.
double rotationAngle(const Eigen::Matrix3d& R);

/// The nearest rotation: what is left of one after rounding, or a mean of several.
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& M);

/// Rigid motion of the given rotation and translation.
Eigen::Isometry3d rigid(const Eigen::Matrix3d& R, const Eigen::Vector3d& t);

}  // namespace planar_bin_picking
