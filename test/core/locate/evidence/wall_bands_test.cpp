// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/wall_bands.h"

#include "support/stages.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

/// Its walls are seen 2 pixels wide or less.
sim::Plate thinPlate(double thickness_mm) {
  sim::Plate plate;
  plate.outer = rectangle(-40, -12, 40, 12);
  plate.thickness_mm = thickness_mm;
  return plate;
}

/// Tilted about its long axis.
Eigen::Isometry3d tilted(double degrees) {
  return sim::poseOf({0, 0, 700, 20, 0}) *
         Eigen::AngleAxisd(degrees * kDegrees, Eigen::Vector3d::UnitX());
}

struct Heap {
  double thickness_mm = 2.0, wall_grey = 105.0, cover_mm = 0.0;
};

/// Of `one` over `other` where the plate lies at `truth`.
double bandsOf(const Eigen::Isometry3d& truth, const Eigen::Isometry3d& one,
               const Eigen::Isometry3d& other, const Heap& heap = {}) {
  const auto part = makePart("thin", thinPlate(heap.thickness_mm));
  sim::Scene scene;
  // The wall is what the upper face leaves of the lower one.
  scene.plates.push_back({thinPlate(heap.thickness_mm),
                          truth * Eigen::Translation3d(0.0, 0.0, -1e-3 * heap.thickness_mm),
                          heap.wall_grey});
  scene.plates.push_back({thinPlate(heap.thickness_mm), truth});
  if (heap.cover_mm > 0.0)
    scene.plates.push_back(
        {{rectangle(-50, -40, -40 + heap.cover_mm, 40), {}, {}, 0.0}, truth, 200.0});
  const Shot shot = shoot(scene);
  const auto points = localPoints(*part, 320, [](const OutlinePoint&) { return true; });
  const Eigen::Isometry3d T_part_centre = centreOf(*part, Face::kFront);
  return wallBands(shot.edges, shot.camera, points, solidOf(*part, Face::kFront),
                   one * T_part_centre, other * T_part_centre);
}

TEST(WallBands, SpeakForTheTiltWhoseWallsAreSeen) {
  for (const double tilt_deg : {-12.0, -6.0, 6.0, 12.0}) {
    for (const double wall_grey : {90.0, 105.0, 120.0}) {
      const Heap heap{2.0, wall_grey};
      const auto truth = tilted(tilt_deg), other = tilted(-tilt_deg);
      EXPECT_GT(bandsOf(truth, truth, other, heap), 0.3) << tilt_deg << " " << wall_grey;
      EXPECT_LT(bandsOf(truth, other, truth, heap), -0.3) << tilt_deg << " " << wall_grey;
    }
  }
}

TEST(WallBands, SayLittleWhereTheTiltsDifferLittle) {
  const double far = bandsOf(tilted(12.0), tilted(12.0), tilted(-12.0)),
               near = bandsOf(tilted(1.0), tilted(1.0), tilted(-1.0));
  EXPECT_LT(std::abs(near), 0.3 * far);
}

TEST(WallBands, SayNothing) {
  EXPECT_EQ(bandsOf(tilted(12.0), tilted(12.0), tilted(12.0)), 0.0) << "of one pose";
  EXPECT_EQ(bandsOf(tilted(12.0), tilted(12.0), tilted(-12.0), {0.0}), 0.0)
      << "of a sheet of unknown thickness";
  // The lower edge of so wide a wall is far away.
  const double wide = bandsOf(tilted(40.0), tilted(40.0), tilted(-40.0), {40.0});
  EXPECT_LT(std::abs(wide), 0.3);
}

TEST(WallBands, DoNotDependOnTheOrder) {
  const double one = bandsOf(tilted(12.0), tilted(12.0), tilted(-11.0)),
               other = bandsOf(tilted(12.0), tilted(-11.0), tilted(12.0));
  EXPECT_NE(one, 0.0);
  EXPECT_DOUBLE_EQ(one, -other);
}

TEST(WallBands, SpeakLessWhereHalfIsCovered) {
  const Heap half{2.0, 105.0, 40.0};
  const double whole = bandsOf(tilted(10.0), tilted(10.0), tilted(-10.0)),
               one = bandsOf(tilted(10.0), tilted(10.0), tilted(-10.0), half),
               other = bandsOf(tilted(10.0), tilted(-10.0), tilted(10.0), half);
  EXPECT_GT(one, 0.05);
  EXPECT_LT(other, -0.05);
  EXPECT_LT(one, whole);
}

}  // namespace
}  // namespace planar_bin_picking
