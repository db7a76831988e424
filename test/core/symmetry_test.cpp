// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/symmetry.h"

#include "support/drawing_fixture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

using SymmetryOf = DrawingTest;

/// Angle between two axes, each a line without direction.
double axisDifference(double a, double b) {
  const double difference = std::fmod(std::abs(a - b), kPi);
  return std::min(difference, kPi - difference);
}

/// Whether `axis` is one of the `order` mirror axes of which `known` is one.
testing::AssertionResult isAxis(const Symmetry& symmetry, double known, int order) {
  double nearest = kPi;
  for (int k = 0; k < order; ++k)
    nearest = std::min(nearest, axisDifference(symmetry.mirror_axis, known + k * kPi / order));
  auto result =
      symmetry.mirror && nearest < 1e-3 ? testing::AssertionSuccess() : testing::AssertionFailure();
  return result << "mirror " << symmetry.mirror << ", axis off by " << nearest << " rad";
}

/// A regular polygon of n corners, turned, about (x, y).
std::vector<std::vector<double>> regular(int n, double radius, double turn = 0.0, double x = 0.0,
                                         double y = 0.0) {
  std::vector<std::vector<double>> vertices;
  for (int i = 0; i < n; ++i) {
    const double angle = turn + 2.0 * kPi * i / n;
    vertices.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle)});
  }
  return vertices;
}

TEST_F(SymmetryOf, RegularPolygons) {
  for (const int n : {3, 4, 5, 6, 15, 24}) {
    const Symmetry symmetry =
        findSymmetry(load(DxfWriter().polyline(regular(n, 40, 0.3, 70, -20))));
    EXPECT_EQ(symmetry.order, n);
    EXPECT_EQ(symmetry.order_print, n);
    EXPECT_TRUE(isAxis(symmetry, 0.3, n)) << n;
    EXPECT_NEAR(symmetry.center.x(), 0.070, 1e-9);
    EXPECT_NEAR(symmetry.center.y(), -0.020, 1e-9);
  }
}

TEST_F(SymmetryOf, Rings) {
  const Symmetry symmetry = findSymmetry(load(DxfWriter().circle(5, 6, 30).circle(5, 6, 10)));
  EXPECT_EQ(symmetry.order, 0);
  EXPECT_EQ(symmetry.order_print, 0);
  EXPECT_TRUE(symmetry.mirror);
}

TEST_F(SymmetryOf, RingsWithHolesOffCentre) {
  EXPECT_EQ(findSymmetry(load(DxfWriter().circle(0, 0, 30).circle(0.5, 0, 10))).order, 1);
  DxfWriter bolts;
  bolts.circle(0, 0, 30);
  for (int i = 0; i < 8; ++i)
    bolts.circle(20 * std::cos(0.2 + i * kPi / 4), 20 * std::sin(0.2 + i * kPi / 4), 3);
  const Symmetry symmetry = findSymmetry(load(bolts));
  EXPECT_EQ(symmetry.order, 8);
  EXPECT_TRUE(isAxis(symmetry, 0.2, 8));
}

TEST_F(SymmetryOf, AKeywayBreaksTheTurnNotTheMirror) {
  DxfWriter dxf;
  dxf.polyline(regular(15, 40, kPi / 2)).polyline({{-2, -2}, {2, -2}, {2, 12}, {-2, 12}});
  const Symmetry symmetry = findSymmetry(load(dxf));
  EXPECT_EQ(symmetry.order, 1);
  EXPECT_TRUE(isAxis(symmetry, kPi / 2, 1));
}

TEST_F(SymmetryOf, TurnsWithoutMirror) {
  DxfWriter dxf;  // a pinwheel: four-fold, but chiral
  std::vector<std::vector<double>> vertices;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Rotation2Dd turn(i * kPi / 2);
    for (const Eigen::Vector2d& p :
         {Eigen::Vector2d(10, -10), Eigen::Vector2d(40, -10), Eigen::Vector2d(30, 4)}) {
      const Eigen::Vector2d q = turn * p;
      vertices.push_back({q.x(), q.y()});
    }
  }
  const Symmetry symmetry = findSymmetry(load(dxf.polyline(vertices)));
  EXPECT_EQ(symmetry.order, 4);
  EXPECT_FALSE(symmetry.mirror);
}

TEST_F(SymmetryOf, ChiralParts) {
  const Symmetry symmetry =
      findSymmetry(loadDrawing(std::string(PACKAGE_DIR) + "/config/parts/bracket.dxf"));
  EXPECT_EQ(symmetry.order, 1);
  EXPECT_FALSE(symmetry.mirror);
}

TEST_F(SymmetryOf, CentroidIsThatOfTheMaterial) {
  // 40 x 20 plate less a 10 x 10 hole about (30, 10).
  const Symmetry symmetry =
      findSymmetry(load(DxfWriter().rectangle(0, 0, 40, 20).rectangle(25, 5, 35, 15)));
  EXPECT_NEAR(symmetry.center.x(), 1e-3 * (800.0 * 20 - 100.0 * 30) / 700.0, 1e-9);
  EXPECT_NEAR(symmetry.center.y(), 0.010, 1e-9);
  EXPECT_EQ(symmetry.order, 1);
  EXPECT_TRUE(isAxis(symmetry, 0.0, 1));
}

TEST_F(SymmetryOf, PrintsBreakIt) {
  DxfWriter dxf;
  dxf.rectangle(-40, -40, 40, 40).rectangle(-20, -10, 20, 10, "PRINT");
  Symmetry symmetry = findSymmetry(load(dxf));
  EXPECT_EQ(symmetry.order, 4);
  EXPECT_EQ(symmetry.order_print, 2);
  symmetry = findSymmetry(load(dxf.line(5, 20, 10, 20, "PRINT")));
  EXPECT_EQ(symmetry.order, 4);
  EXPECT_EQ(symmetry.order_print, 1);
  DxfWriter round;
  round.circle(0, 0, 30).rectangle(-10, -10, 10, 10, "PRINT");
  symmetry = findSymmetry(load(round));
  EXPECT_EQ(symmetry.order, 0);
  EXPECT_EQ(symmetry.order_print, 4);
}

TEST_F(SymmetryOf, SmallNotchesCount) {
  // Half a millimetre of 80: more than the tolerance, so the turn is not a symmetry.
  const std::vector<std::vector<double>> notched = {{0, 0},  {80, 0},     {80, 40}, {0, 40},
                                                    {0, 30}, {0.5, 29.5}, {0, 29}};
  EXPECT_EQ(findSymmetry(load(DxfWriter().polyline(notched))).order, 1);
  EXPECT_EQ(findSymmetry(load(DxfWriter().polyline(notched)), 0.6e-3).order, 2);
}

TEST_F(SymmetryOf, TheFigureMapsToItselfWhereverItIsTurned) {
  // Turning the drawing turns the axis and changes nothing else.
  for (const double turn : {0.0, 0.4, 1.1, 2.9}) {
    DxfWriter dxf;
    std::vector<std::vector<double>> kite;
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(50, 0), Eigen::Vector2d(0, 20),
                                     Eigen::Vector2d(-30, 0), Eigen::Vector2d(0, -20)}) {
      const Eigen::Vector2d q = Eigen::Rotation2Dd(turn) * p;
      kite.push_back({q.x(), q.y()});
    }
    const Symmetry symmetry = findSymmetry(load(dxf.polyline(kite)));
    EXPECT_EQ(symmetry.order, 1);
    EXPECT_TRUE(isAxis(symmetry, turn, 1)) << turn;
    EXPECT_GE(symmetry.mirror_axis, 0.0);
    EXPECT_LT(symmetry.mirror_axis, kPi);
  }
}

TEST(Symmetry, RefusesADrawingWithoutOutline) {
  EXPECT_TRUE(refuses([] { findSymmetry(Drawing()); }, {"no outline"}));
}

}  // namespace
}  // namespace planar_bin_picking
