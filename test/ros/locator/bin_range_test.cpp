// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/bin_range.h"

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

TEST(BinRange, TheFloorFacesTheCameraWhicheverWayZPoints) {
  const Eigen::Isometry3d T_camera_bin = lookingDown(1.0, 0.3);
  const Eigen::Vector3d up = floorNormal(cell(), T_camera_bin);
  EXPECT_TRUE(up.isApprox(T_camera_bin.linear().col(2)));
  EXPECT_LT(up.z(), -0.9);
  const Eigen::Isometry3d turned = T_camera_bin * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  EXPECT_TRUE(floorNormal(cell(), turned).isApprox(up));
}

TEST(BinRange, RefusesBinBehindCamera) {
  EXPECT_TRUE(planar_bin_picking::refuses([] { distanceRange(cell(), lookingDown(0.1, 0.0)); },
                                          {"behind", "bin_frame"}));
}

TEST(BinRange, RefusesDistancesThatCannotBeSearched) {
  using planar_bin_picking::refuses;
  CellParams deep = cell();
  deep.bin_max[2] = 0.95;  // from 5 cm to 1 m below the camera
  EXPECT_TRUE(refuses([&] { distanceRange(deep, lookingDown(1.0, 0.0)); }, {"bin", "min"}));
  deep.bin_max[2] = 1.0 - 1e-9;
  EXPECT_TRUE(refuses([&] { distanceRange(deep, lookingDown(1.0, 0.0)); }, {"bin", "min"}));
  EXPECT_TRUE(refuses([] { distanceRange(cell(), lookingDown(500.0, 0.0)); }, {"bin", "max"}));
}

}  // namespace
}  // namespace planar_bin_picking_ros
