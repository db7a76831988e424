// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/base/se3.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

std::vector<Vector6d> motions() {
  std::vector<Vector6d> out(5);
  out[0].setZero();
  out[1] << 1.0, -2.0, 3.0, 0.0, 0.0, 0.0;
  out[2] << 0.1, 0.2, -0.3, 1e-7, -2e-7, 1e-7;
  out[3] << 0.1, 0.2, -0.3, 0.4, -1.2, 0.9;
  out[4] << -1.0, 0.5, 2.0, 0.0, 3.1, 0.0;
  return out;
}

TEST(Se3, LogInvertsExp) {
  for (const Vector6d& xi : motions())
    EXPECT_LT((log(exp(xi)) - xi).norm(), 1e-9) << xi.transpose();
}

TEST(Se3, ExpOfTwiceIsTheSquare) {
  for (const Vector6d& xi : motions()) {
    const Eigen::Isometry3d once = exp(xi);
    EXPECT_TRUE(isometryNear(exp(2.0 * xi), once * once, 1e-9, 1e-7));
  }
}

// The exponential map turns the translation along: a quarter turn about z while driving along x.
TEST(Se3, ExpDrivesAnArc) {
  Vector6d xi;
  const double quarter = 0.5 * 3.14159265358979323846;
  xi << quarter, 0.0, 0.0, 0.0, 0.0, quarter;
  EXPECT_LT((exp(xi).translation() - Eigen::Vector3d(1.0, 1.0, 0.0)).norm(), 1e-12);
}

TEST(Se3, SeriesMeetsTheClosedForm) {
  Vector6d below, above;
  below << 0.3, -0.2, 0.5, 0.99e-4, 0.0, 0.0;
  above << 0.3, -0.2, 0.5, 1.01e-4, 0.0, 0.0;
  EXPECT_LT((exp(below).matrix() - exp(above).matrix()).norm(), 3e-6);  // of 2e-6 rad
  EXPECT_LT((log(exp(below)) - below).norm(), 1e-12);
}

TEST(Se3, NearestRotationMends) {
  const Eigen::Matrix3d R = exp(motions()[3]).linear();
  EXPECT_LT((nearestRotation(1.7 * R) - R).norm(), 1e-12);
  const Eigen::Matrix3d mirrored = R * Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal();
  EXPECT_NEAR(nearestRotation(mirrored).determinant(), 1.0, 1e-12);
}

TEST(Se3, RotationVectorIsTheShortWay) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(5.0, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_NEAR(rotationVector(R).y(), 5.0 - 2.0 * 3.14159265358979323846, 1e-12);
  EXPECT_NEAR(rotationAngle(R), 2.0 * 3.14159265358979323846 - 5.0, 1e-12);
}

}  // namespace
}  // namespace planar_bin_picking
