// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part/part_extent.h"

#include "support/plates.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

sim::Plate bar(double length_mm, double width_mm, double turn_deg = 0.0) {
  sim::Plate plate;
  for (const auto& p :
       rectangle(-0.5 * length_mm, -0.5 * width_mm, 0.5 * length_mm, 0.5 * width_mm))
    plate.outer.push_back(Eigen::Rotation2Dd(turn_deg * kDegrees) * p);
  return plate;
}

TEST(PartExtent, TheMeanWidthIsTheDistanceFromEdgeToEdge) {
  EXPECT_NEAR(meanWidthOf(*makePart("bar", bar(300, 20))), 1e-3 * 2 * 6000 / 640, 1e-6);
  sim::Plate ring = bar(100, 100);
  ring.holes.push_back(rectangle(-40, -40, 40, 40));
  EXPECT_NEAR(meanWidthOf(*makePart("frame", ring)), 1e-3 * 2 * 3600 / 720, 1e-6);
  EXPECT_NEAR(meanWidthOf(*makePart("printed", printedPlate())),
              1e-3 * 2 * (3600 - 4 * 16 * M_PI) / (240 + 4 * 8 * M_PI), 2e-5);
}

TEST(PartExtent, TheExtentIsThatOfTheTightestRectangle) {
  for (const double turn : {0.0, 30.0, 77.0, 90.0}) {
    const Extent extent = extentOf(*makePart("bar", bar(80, 12, turn)));
    EXPECT_NEAR(extent.length, 0.080, 1e-6) << turn;
    EXPECT_NEAR(extent.width, 0.012, 1e-6) << turn;
  }
}

TEST(PartExtent, ABarIsSlenderAndABracketIsNot) {
  for (const double turn : {0.0, 30.0, 77.0, 90.0}) {
    const auto length = lengthOfSlender(*makePart("bar", bar(80, 12, turn)));
    ASSERT_TRUE(length) << turn;
    const Eigen::Vector2d truth(std::cos(turn * kDegrees), std::sin(turn * kDegrees));
    EXPECT_GT(std::abs(length->dot(truth)), std::cos(2.0 * kDegrees)) << turn;
  }
  EXPECT_FALSE(lengthOfSlender(*makePart("bracket", bracketPlate())));
  // As narrow, but all around: tilt and bevel look different.
  EXPECT_FALSE(lengthOfSlender(*makePart("square", bar(12, 12))));
}

TEST(PartExtent, TheGrainOfASlenderPartIsItsWidth) {
  EXPECT_NEAR(grainOf(*makePart("bar", slenderPlate())), 0.010, 1e-6);
  const auto bracket = makePart("bracket", bracketPlate());
  EXPECT_NEAR(grainOf(*bracket), bracket->radius(), 1e-9);
}

}  // namespace
}  // namespace planar_bin_picking
