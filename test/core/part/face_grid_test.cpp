// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/face_grid.h"

#include "support/plates.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

FaceGrid gridOf(const sim::Plate& plate) {
  return FaceGrid(makePart("plate", plate)->file().drawing);
}

double areaOf(const FaceGrid& grid) {
  return 1e6 * static_cast<double>(grid.cells().size()) * grid.cellSize() * grid.cellSize();
}

TEST(FaceGrid, CellsCoverTheFaceWithoutItsHoles) {
  sim::Plate plate;
  plate.outer = rectangle(-40, -25, 40, 25);
  EXPECT_NEAR(areaOf(gridOf(plate)), 80.0 * 50.0, 40.0);
  plate.holes = {circle(-10, 0, 15, true)};
  const FaceGrid grid = gridOf(plate);
  EXPECT_NEAR(areaOf(grid), 80.0 * 50.0 - 706.9, 60.0);
  for (const auto& cell : grid.cells())
    EXPECT_GT((cell - Eigen::Vector2d(-0.010, 0.0)).norm(), 0.0135);
}

TEST(FaceGrid, ANarrowRingHasCellsToo) {
  for (const double width_mm : {2.0, 0.5, 0.05}) {
    sim::Plate plate;
    plate.outer = circle(0, 0, 60);
    plate.holes = {circle(0, 0, 60 - width_mm, true)};
    const FaceGrid grid = gridOf(plate);
    EXPECT_GE(grid.cells().size(), 60u) << width_mm;
    for (const auto& cell : grid.cells())
      EXPECT_NEAR(1e3 * cell.norm(), 60 - 0.5 * width_mm, 0.5 * width_mm + 1e3 * grid.cellSize());
  }
}

TEST(FaceGrid, LinksJoinNeighbours) {
  const FaceGrid grid = gridOf(bracketPlate());
  ASSERT_FALSE(grid.links().empty());
  for (const FaceGrid::Link& link : grid.links()) {
    const Eigen::Vector2d step = grid.cells()[link.second] - grid.cells()[link.first];
    const Eigen::Vector2d expected =
        grid.cellSize() * (link.along_x ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY());
    EXPECT_LT((step - expected).norm(), 1e-12);
    const Eigen::Vector2d middle =
        0.5 * (grid.corner(link.col, link.row) + grid.corner(link.col + 1, link.row + 1));
    EXPECT_LT((middle - grid.cells()[link.first]).norm(), 1e-12);
  }
}

TEST(FaceGrid, FindsTheCellAboutAPointOrNextToIt) {
  sim::Plate plate;
  plate.outer = rectangle(0, 0, 40, 20);  // cells of 1 mm
  const FaceGrid grid = gridOf(plate);
  const int cell = grid.cellNear({0.0103, 0.0052});
  ASSERT_GE(cell, 0);
  EXPECT_LT((grid.cells()[cell] - Eigen::Vector2d(0.0105, 0.0055)).norm(), 1e-9);
  EXPECT_GE(grid.cellNear({-0.0004, 0.01}), 0);
  EXPECT_EQ(grid.cellNear({-0.005, 0.01}), -1);
}

TEST(FaceGrid, MeasuresFromEveryLineOfTheDrawing) {
  const FaceGrid grid = gridOf(printedPlate());  // 60 x 60 with a printed box
  const auto samplesAt = [&](double x_mm, double y_mm) {
    const Eigen::Vector2d q = FaceGrid::kSamples *
                              (1e-3 * Eigen::Vector2d(x_mm, y_mm) - grid.corner(0, 0)) /
                              grid.cellSize();
    return grid.fromOutline()(static_cast<int>(q.y()), static_cast<int>(q.x()));
  };
  const double sample_mm = 1e3 * grid.cellSize() / FaceGrid::kSamples;
  EXPECT_LT(samplesAt(-30, 0), 1.5);
  EXPECT_LT(samplesAt(0, 2), 1.5);  // on the print
  EXPECT_NEAR(samplesAt(0, -12) * sample_mm, 14.0, 1.0);
}

}  // namespace
}  // namespace planar_bin_picking
