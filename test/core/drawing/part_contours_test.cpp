// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/part_contours.h"

#include "support/drawing_fixture.h"

#include <ctime>

namespace planar_bin_picking {
namespace {

class PartContours : public DrawingTest {
 protected:
  static std::vector<Eigen::Vector2d> smoothed(const std::vector<Eigen::Vector2d>& points,
                                               bool closed = true) {
    Contour contour{"LINE", "CUT", closed, points};
    smooth(&contour, 0.05);
    return contour.points;
  }
  testing::AssertionResult isSquare(const std::vector<std::vector<double>>& vertices) {
    const Drawing drawing = load(DxfWriter().polyline(vertices));
    const double off = std::abs(areaMm2(drawing) - 800.0);
    auto result = off < 0.5 && drawing.loops[0].points.size() <= 5 ? testing::AssertionSuccess()
                                                                   : testing::AssertionFailure();
    return result << off << " mm2, " << drawing.loops[0].points.size() << " points";
  }
};

TEST_F(PartContours, LoseSpikesBelowTheTolerance) {
  EXPECT_TRUE(isSquare({{0, 0}, {40, 0}, {40, 20}, {0, 20}, {0, -0.0035}}));
  EXPECT_TRUE(isSquare({{0, -0.0035}, {0, 0}, {40, 0}, {40, 20}, {0, 20}}));  // at the seam
  EXPECT_TRUE(isSquare({{0, 0}, {40, 0}, {40, 20.04}, {40, 20}, {0, 20}}));
  EXPECT_TRUE(
      isSquare({{0, 0}, {40, 0}, {40, 20.02}, {40, 20.04}, {40, 20.01}, {40, 20}, {0, 20}}));
  EXPECT_TRUE(isSquare({{0, 0}, {20, 0}, {20, -0.03}, {20, 0}, {40, 0}, {40, 20}, {0, 20}}));
  EXPECT_TRUE(refused(DxfWriter().polyline({{0, 0}, {40, 0}, {40, 20}, {0, 20}, {0, -0.06}}),
                      {"touches itself"}));
}

TEST_F(PartContours, LoseOvershootsBelowTheTolerance) {
  EXPECT_TRUE(isSquare({{-0.03, 0}, {40, 0}, {40, 20}, {0, 20}, {0, -0.03}}));
  EXPECT_TRUE(isSquare({{0, 0}, {40.03, 0}, {40, -0.03}, {40, 20}, {0, 20}}));
  EXPECT_TRUE(refused(DxfWriter().polyline({{-0.3, 0}, {40, 0}, {40, 20}, {0, 20}, {0, -0.3}}),
                      {"crosses"}));
}

TEST_F(PartContours, KeepTheirShape) {
  const std::vector<Eigen::Vector2d> step = {{0, 0},       {9, 0},    {9, 0.03},
                                             {9.03, 0.03}, {9.03, 5}, {0, 5}};
  EXPECT_EQ(smoothed(step), step);
  const std::vector<Eigen::Vector2d> spike = {{0, 0}, {9, 0}, {9, 0.03}, {9, 0}};
  EXPECT_EQ(smoothed(spike, false), spike);  // as in prints, which may end
  std::vector<Eigen::Vector2d> fine;
  for (int i = 0; i < 500; ++i)
    fine.emplace_back(std::cos(2 * kPi * i / 500), std::sin(2 * kPi * i / 500));
  EXPECT_EQ(smoothed(fine), fine);
  EXPECT_EQ(smoothed({{0, 0}, {0, 5e-5}, {9, 0}, {9, 5}, {5e-5, 0}}).size(), 3u);
}

TEST_F(PartContours, EncloseSomething) {
  EXPECT_TRUE(refused(DxfWriter().rectangle(0, 0, 40, 20).polyline({{5, 5}, {9, 5}}),
                      {"LWPOLYLINE", "encloses nothing", "(5.000, 5.000) mm"}));
}

TEST_F(PartContours, HaveCornersWhereTheirLinesLead) {
  DrawingParams params;
  params.join_tolerance_mm = 0.1;
  const DxfWriter gap =
      DxfWriter().polyline({{0, 0}, {40, 0}, {40, 20}, {0, 20}, {0, 0.092}}, false);
  EXPECT_TRUE(refused(gap, {"open contour", "0.092 mm"}));
  EXPECT_NEAR(areaMm2(load(gap, params)), 800.0, 1e-6);
  DxfWriter lines;  // too short by 0.03 here, too long by 0.02 there
  lines.line(0, 0, 39.97, 0).line(40, -0.02, 40, 20).line(40, 20, 0, 20).line(0, 20, 0, 0);
  EXPECT_NEAR(areaMm2(load(lines)), 800.0, 1e-6);
  DxfWriter flat;  // in one line: in the middle
  flat.line(0, 0, 19.98, 0).line(20.02, 0, 40, 0).line(40, 0, 40, 20).line(40, 20, 0, 20);
  const Loop loop = load(flat.line(0, 20, 0, 0)).loops.at(0);
  EXPECT_TRUE(std::any_of(loop.points.begin(), loop.points.end(), [](const Eigen::Vector2d& p) {
    return (1e3 * p - Eigen::Vector2d(20, 0)).norm() < 1e-9;
  }));
}

TEST_F(PartContours, FarFromTheOriginAreAsExact) {
  const auto part = [this](double x, double y) {
    DxfWriter dxf;
    dxf.polyline({{x, y}, {x + 60, y, 0.3}, {x + 60, y + 40}, {x, y + 40, 1e-7}});
    dxf.circle(x + 30, y + 20, 8).arc(x + 10, y + 10, 3, 0, 180);
    return load(dxf.line(x + 7, y + 10, x + 13, y + 10));
  };
  const Drawing near = part(0, 0), far = part(1e7, -5e6);
  ASSERT_EQ(near.loops.size(), far.loops.size());
  for (std::size_t i = 0; i < near.loops.size(); ++i) {
    ASSERT_EQ(near.loops[i].points.size(), far.loops[i].points.size());
    for (std::size_t k = 0; k < near.loops[i].points.size(); ++k) {
      const Eigen::Vector2d moved = far.loops[i].points[k] - Eigen::Vector2d(1e4, -5e3);
      EXPECT_LT((moved - near.loops[i].points[k]).norm(), 1e-10);
    }
  }
  EXPECT_TRUE(near.warnings.empty());
  EXPECT_TRUE(says(far.warnings, {"11180 m from the drawing's origin"}));
  EXPECT_TRUE(part(99e3, 0).warnings.empty());
  EXPECT_TRUE(says(part(0, 101e3).warnings, {"101 m"}));
}

TEST_F(PartContours, OfThousandsOfHolesAreReadFast) {
  DxfWriter dxf = DxfWriter().rectangle(0, 0, 610, 510);
  for (int i = 0; i < 3000; ++i) dxf.circle(5 + 10 * (i % 60), 5 + 10 * (i / 60), 3);
  const std::clock_t start = std::clock();
  EXPECT_EQ(load(dxf).loops.size(), 3001u);
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 10.0);  // 0.3 s; sanitizers
}

}  // namespace
}  // namespace planar_bin_picking
