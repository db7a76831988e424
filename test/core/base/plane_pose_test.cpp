// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/plane_pose.h"

#include "support/matchers.h"

#include <gtest/gtest.h>

#include <random>

namespace planar_bin_picking {
namespace {

/// Planes in front of a camera, either face toward it, tilted by up to 60 degrees.
class PlanePose : public testing::Test {
 protected:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  Eigen::Isometry3d randomPose() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const double azimuth = uniform(0.0, 6.28);
    const Eigen::Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0.0);
    const double flip = uniform(0.0, 1.0) < 0.5 ? 0.0 : 3.14159265358979;
    T.linear() = (Eigen::AngleAxisd(uniform(0.0, 1.05), axis) *
                  Eigen::AngleAxisd(uniform(0.0, 6.28), Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(flip, Eigen::Vector3d::UnitX()))
                     .toRotationMatrix();
    T.translation() << uniform(-0.3, 0.3), uniform(-0.2, 0.2), uniform(0.3, 2.0);
    return T;
  }

  /// What the plane's points do in the ideal image, to first order about its origin.
  static Eigen::Matrix2d affineOf(const Eigen::Isometry3d& T) {
    const auto seen = [&T](const Eigen::Vector2d& p) -> Eigen::Vector2d {
      return (T * Eigen::Vector3d(p.x(), p.y(), 0.0)).hnormalized();
    };
    return numericJacobian(seen, Eigen::Vector2d(0.0, 0.0), 1e-5);
  }

  static Eigen::Vector2d originOf(const Eigen::Isometry3d& T) {
    return T.translation().hnormalized();
  }

  std::mt19937 random_{7};
};

TEST_F(PlanePose, TheTruePoseIsOneOfTheTwo) {
  for (int i = 0; i < 200; ++i) {
    const Eigen::Isometry3d T = randomPose();
    const auto poses = posesFromAffine(affineOf(T), originOf(T));
    // Differences over 1e-5 leave 1e-9 in A; near an untilted plane the tilt is the root of that.
    const auto first = isometryNear(poses[0], T, 1e-6, 1e-4);
    EXPECT_TRUE(first || isometryNear(poses[1], T, 1e-6, 1e-4)) << i << ": " << first.message();
  }
}

TEST_F(PlanePose, BothLookTheSame) {
  for (int i = 0; i < 200; ++i) {
    const Eigen::Isometry3d T = randomPose();
    const Eigen::Matrix2d A = affineOf(T);
    for (const auto& pose : posesFromAffine(A, originOf(T))) {
      EXPECT_LT((affineOf(pose) - A).norm(), 1e-7 * A.norm()) << i;
      EXPECT_LT((originOf(pose) - originOf(T)).norm(), 1e-12) << i;
      EXPECT_NEAR(pose.linear().determinant(), 1.0, 1e-12) << i;
      EXPECT_LT((pose.linear().transpose() * pose.linear() - Eigen::Matrix3d::Identity()).norm(),
                1e-12);
    }
  }
}

TEST_F(PlanePose, TheyMirrorTheNormalAboutTheLineOfSight) {
  for (int i = 0; i < 200; ++i) {
    const Eigen::Isometry3d T = randomPose();
    const auto poses = posesFromAffine(affineOf(T), originOf(T));
    const Eigen::Vector3d ray = T.translation().normalized();
    const Eigen::Vector3d sum = poses[0].linear().col(2) + poses[1].linear().col(2);
    EXPECT_LT(sum.cross(ray).norm(), 1e-6) << i;
  }
}

TEST_F(PlanePose, TheyCoincideWhereNothingIsForeshortened) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.2, -0.1, 0.8;
  T.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), T.translation()).matrix();
  const auto poses = posesFromAffine(affineOf(T), originOf(T));
  // As above: the tilt is the root of what the differences leave.
  EXPECT_TRUE(isometryNear(poses[0], T, 1e-6, 1e-4));
  EXPECT_TRUE(isometryNear(poses[1], T, 1e-6, 1e-4));
}

}  // namespace
}  // namespace planar_bin_picking
