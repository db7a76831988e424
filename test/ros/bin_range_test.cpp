// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bin_range.h"

#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking_ros {
namespace {

CellParams cell() {
  CellParams params;
  params.bin_frame = "bin";
  params.bin_min = {-0.2, -0.1, 0.0};
  params.bin_max = {0.2, 0.1, 0.15};
  return params;
}

Eigen::Isometry3d lookingDown(const double height, const double tilt) {
  const Eigen::AngleAxisd down(M_PI + tilt, Eigen::Vector3d::UnitX());
  const Eigen::Isometry3d T_bin_camera = Eigen::Translation3d(0.0, 0.0, height) * down;
  return T_bin_camera.inverse();
}

TEST(BinRange, StraightDown) {
  const DistanceRange range = distanceRange(cell(), lookingDown(1.0, 0.0));
  EXPECT_NEAR(range.min, 0.85, 1e-12);
  EXPECT_NEAR(range.max, 1.0, 1e-12);
}

TEST(BinRange, ObliqueReachesFurther) {
  const double tilt = 0.3;
  const DistanceRange range = distanceRange(cell(), lookingDown(1.0, tilt));
  EXPECT_NEAR(range.min, 0.85 * std::cos(tilt) - 0.1 * std::sin(tilt), 1e-12);
  EXPECT_NEAR(range.max, 1.0 * std::cos(tilt) + 0.1 * std::sin(tilt), 1e-12);
}

TEST(BinRange, RefusesBinBehindCamera) {
  EXPECT_TRUE(planar_bin_picking::refuses([] { distanceRange(cell(), lookingDown(0.1, 0.0)); },
                                          {"behind", "bin_frame"}));
}

}  // namespace
}  // namespace planar_bin_picking_ros
