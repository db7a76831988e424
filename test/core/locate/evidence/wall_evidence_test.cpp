// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/wall_evidence.h"

#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

sim::Plate thickPlate() {
  sim::Plate plate;
  plate.outer = rectangle(-40, -12, 40, 12);
  plate.thickness_mm = 6.0;
  return plate;
}

/// Tilted about its long axis.
Eigen::Isometry3d tilted(double degrees) {
  return sim::poseOf({0, 0, 700, 20, 0}) *
         Eigen::AngleAxisd(degrees * kDegrees, Eigen::Vector3d::UnitX());
}

/// Score of the walls of `pose` where the plate lies at `truth`; `cover_mm` of its length
/// are covered.
std::optional<double> wallScoreOf(const Eigen::Isometry3d& truth, const Eigen::Isometry3d& pose,
                                  double cover_mm = 0.0) {
  const auto part = makePart("thick", thickPlate());
  sim::Scene scene;
  // The wall is what the upper face leaves of the lower one.
  scene.plates.push_back({thickPlate(), truth * Eigen::Translation3d(0.0, 0.0, -0.006), 105.0});
  scene.plates.push_back({thickPlate(), truth});
  if (cover_mm > 0.0)
    scene.plates.push_back({{rectangle(-50, -40, -40 + cover_mm, 40), {}, {}, 0.0}, truth, 200.0});
  const Shot shot = shoot(scene);
  const auto points = localPoints(*part, 320, [](const OutlinePoint&) { return true; });
  return wallScore(shot.edges, shot.camera, points, solidOf(*part, Face::kFront),
                   pose * centreOf(*part, Face::kFront));
}

TEST(WallEvidence, SpeaksForTheSideOnWhichTheWallIs) {
  for (const double tilt_deg : {-18.0, 18.0}) {
    const auto right = wallScoreOf(tilted(tilt_deg), tilted(tilt_deg)),
               other = wallScoreOf(tilted(tilt_deg), tilted(-tilt_deg));
    ASSERT_TRUE(right && other) << tilt_deg;
    EXPECT_GT(*right, 0.8) << tilt_deg;
    EXPECT_LT(*other, 0.3) << tilt_deg;
  }
}

TEST(WallEvidence, SaysNothingWhereNoWallIsInView) {
  EXPECT_FALSE(wallScoreOf(tilted(1.0), tilted(1.0)));
}

TEST(WallEvidence, ACoveredWallDoesNotCount) {
  const auto half = wallScoreOf(tilted(18.0), tilted(18.0), 40.0);
  ASSERT_TRUE(half);
  EXPECT_GT(*half, 0.8);
  EXPECT_FALSE(wallScoreOf(tilted(18.0), tilted(18.0), 95.0));
}

}  // namespace
}  // namespace planar_bin_picking
