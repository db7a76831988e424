// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/common_normal.h"

#include "support/plates.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// A slender part along x that is tilted about its length by `roll_deg`, on a floor that is seen
/// `floor_deg` obliquely, turned by `yaw_deg` on it.
MeasuredNormal slender(double yaw_deg, double roll_deg, double floor_deg = 0.0) {
  Eigen::Isometry3d T(Eigen::AngleAxisd(floor_deg * kDegrees, Eigen::Vector3d::UnitX()) *
                      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()) *
                      Eigen::AngleAxisd(yaw_deg * kDegrees, Eigen::Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(roll_deg * kDegrees, Eigen::Vector3d::UnitX()));
  return measuredNormal(T, Face::kFront, 1e-4 * Eigen::Matrix3d::Identity(),
                        Eigen::Vector2d::UnitX());
}

TEST(CommonNormal, SlenderPartsInSeveralDirectionsTellAFloorSeenObliquely) {
  std::vector<MeasuredNormal> normals;
  for (int i = 0; i < 8; ++i) normals.push_back(slender(40.0 * i, i % 2 == 0 ? 12.0 : -12.0, 15.0));
  const CommonNormal common = commonNormal(normals, kNone);
  const Eigen::Vector3d truth(0.0, std::sin(15.0 * kDegrees), -std::cos(15.0 * kDegrees));
  EXPECT_GT(common.normal.dot(truth), std::cos(3.0 * kDegrees)) << common.normal.transpose();
  EXPECT_GT(common.parts, 4.0);
}

TEST(CommonNormal, WhatIsLeftOutSaysNothing) {
  const CommonNormal common = commonNormal({slender(0.0, 12.0)}, 0);
  EXPECT_EQ(common.parts, 0.0);
  EXPECT_TRUE(std::isfinite(
      logTiltPrior(common, -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), 0.0)));
}

TEST(CommonNormal, ATiltIsLikelyAsTheOthersLieAndNoneIsImpossible) {
  std::vector<MeasuredNormal> normals;
  for (int i = 0; i < 8; ++i) normals.push_back(slender(40.0 * i, 0.0));
  const CommonNormal common = commonNormal(normals, kNone);
  const auto density = [&](double tilt_deg) {
    const Eigen::AngleAxisd turn(tilt_deg * kDegrees, Eigen::Vector3d::UnitX());
    return logTiltPrior(common, turn * -Eigen::Vector3d::UnitZ(), turn * Eigen::Vector3d::UnitY(),
                        tilt_deg * kDegrees);
  };
  EXPECT_GT(density(0.0), density(10.0) + 2.0);
  EXPECT_GT(density(20.0), density(0.0) - 8.0);
}

}  // namespace
}  // namespace planar_bin_picking
