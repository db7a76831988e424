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
  double wall_grey = 140.0, floor_grey = 60.0, thickness_mm = 2.0, cover_mm = 0.0;
  double beside_grey = 0.0;  // of what lies beside one end, if anything
  std::size_t points = 320;
  double face_grey = 150.0, noise = 2.0;
};

/// Of `one` over `other` where the plate lies at `truth`.
double bandsOf(const Eigen::Isometry3d& truth, const Eigen::Isometry3d& one,
               const Eigen::Isometry3d& other, const Heap& heap = {}) {
  const auto part = makePart("thin", thinPlate(heap.thickness_mm));
  sim::Scene scene;
  scene.background = heap.floor_grey;
  scene.noise = heap.noise;
  const auto add = [&](const sim::Ring& ring, double grey) {
    scene.plates.push_back({{ring, {}, {}, 0.0}, truth, grey});
  };
  if (heap.beside_grey > 0.0) add(rectangle(40.6, -40, 60, 40), heap.beside_grey);
  // The wall is what the upper face leaves of the lower one.
  scene.plates.push_back({thinPlate(heap.thickness_mm),
                          truth * Eigen::Translation3d(0.0, 0.0, -1e-3 * heap.thickness_mm),
                          heap.wall_grey});
  scene.plates.push_back({thinPlate(heap.thickness_mm), truth, heap.face_grey});
  if (heap.cover_mm > 0.0) add(rectangle(-50, -40, -40 + heap.cover_mm, 40), 200.0);
  const Shot shot = shoot(scene);
  const auto points = localPoints(*part, heap.points, [](const OutlinePoint&) { return true; });
  const Eigen::Isometry3d T_part_centre = centreOf(*part, Face::kFront);
  return wallBands(shot.edges, shot.camera, points, solidOf(*part, Face::kFront),
                   one * T_part_centre, other * T_part_centre);
}

/// Of the true tilt over the one to the other side.
double bandsOfTruth(double tilt_deg, const Heap& heap = {}) {
  return bandsOf(tilted(tilt_deg), tilted(tilt_deg), tilted(-tilt_deg), heap);
}

TEST(WallBands, SpeakForTheTiltWhoseWallsAreSeen) {
  for (const double tilt_deg : {-12.0, -6.0, 6.0, 12.0}) {
    for (const double wall_grey : {75.0, 90.0, 120.0, 160.0, 190.0}) {
      const auto truth = tilted(tilt_deg), other = tilted(-tilt_deg);
      EXPECT_GT(bandsOf(truth, truth, other, {wall_grey}), 0.3) << tilt_deg << " " << wall_grey;
      EXPECT_LT(bandsOf(truth, other, truth, {wall_grey}), -0.3) << tilt_deg << " " << wall_grey;
    }
  }
}

TEST(WallBands, SpeakForTheTiltWhoseDarkWallsAreSeen) {
  for (const double wall_grey : {5.0, 20.0, 30.0})
    EXPECT_GT(bandsOfTruth(12.0, {wall_grey, 100.0}), 0.6) << wall_grey;
}

TEST(WallBands, SpeakWhereTheFaceIsAsGreyAsTheFloor) {
  Heap saturated{60.0, 255.0};
  saturated.face_grey = 255.0;
  saturated.noise = 0.0;
  EXPECT_GT(bandsOfTruth(12.0, {60.0, 150.0}), 0.6);
  EXPECT_GT(bandsOfTruth(12.0, saturated), 0.6);
}

/// Beside a bright face a dark wall may look as bright as the floor, and then the other side has
/// the contrast, of the blurred edge.
TEST(WallBands, DoNotTakeABlurredEdgeForAWall) {
  for (const double floor_grey : {30.0, 60.0, 100.0}) {
    for (double wall_grey = 5.0; wall_grey <= 150.0; wall_grey += 10.0) {
      for (const double tilt_deg : {-6.0, 12.0})
        EXPECT_GT(bandsOfTruth(tilt_deg, {wall_grey, floor_grey}), -0.1)
            << floor_grey << " " << wall_grey << " " << tilt_deg;
    }
  }
}

TEST(WallBands, SayLittleWhereTheTiltsDifferLittle) {
  EXPECT_LT(std::abs(bandsOfTruth(1.0)), 0.2 * bandsOfTruth(12.0));
  EXPECT_LT(bandsOfTruth(6.0), 0.7 * bandsOfTruth(12.0));
}

TEST(WallBands, SayNothing) {
  EXPECT_EQ(bandsOf(tilted(12.0), tilted(12.0), tilted(12.0)), 0.0) << "of one pose";
  EXPECT_EQ(bandsOfTruth(12.0, {140.0, 60.0, 0.0}), 0.0) << "of a sheet of unknown thickness";
  Heap few;
  few.points = 19;
  EXPECT_EQ(bandsOfTruth(12.0, few), 0.0) << "of a few points";
  // The lower edge of so wide a wall is far away.
  EXPECT_LT(std::abs(bandsOfTruth(40.0, {140.0, 60.0, 40.0})), 0.05);
}

/// Its contrast is four times that of the walls, and no more in one tilt than in the other.
TEST(WallBands, AreNotOutweighedByWhatLiesBeside) {
  const Heap alone{140.0, 100.0}, beside{140.0, 100.0, 2.0, 0.0, 255.0};
  EXPECT_GT(bandsOfTruth(12.0, beside), 0.8 * bandsOfTruth(12.0, alone));
}

TEST(WallBands, DoNotDependOnTheOrder) {
  const double one = bandsOf(tilted(12.0), tilted(12.0), tilted(-11.0)),
               other = bandsOf(tilted(12.0), tilted(-11.0), tilted(12.0));
  EXPECT_NE(one, 0.0);
  EXPECT_DOUBLE_EQ(one, -other);
}

TEST(WallBands, SpeakLessWhereHalfIsCovered) {
  const Heap half{140.0, 60.0, 2.0, 40.0};
  const double whole = bandsOfTruth(10.0), one = bandsOfTruth(10.0, half),
               other = bandsOf(tilted(10.0), tilted(-10.0), tilted(10.0), half);
  EXPECT_GT(one, 0.05);
  EXPECT_LT(other, -0.05);
  EXPECT_LT(one, whole);
}

}  // namespace
}  // namespace planar_bin_picking
