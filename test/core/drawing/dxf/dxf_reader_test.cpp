// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "support/drawing_fixture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

using DxfReader = DrawingTest;

TEST_F(DxfReader, ChainsLinesOfAnyOrderAndDirection) {
  DxfWriter dxf;
  dxf.line(0, 0, 40, 0).line(0, 20, 0, 0).line(40, 20, 40, 0).line(40, 20, 0, 20);
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 1u);
  EXPECT_EQ(drawing.loops[0].kind, LoopKind::kOuter);
  EXPECT_EQ(drawing.loops[0].points.size(), 4u);
  EXPECT_TRUE(drawing.loops[0].closed);
  EXPECT_NEAR(signedArea(drawing.loops[0].points), 800e-6, 1e-12);
}

TEST_F(DxfReader, TurnsOuterLoopsLeftAndHolesRight) {
  DxfWriter dxf;
  dxf.polyline({{0, 0}, {0, 30}, {30, 30}, {30, 0}}).rectangle(5, 5, 10, 10).circle(20, 20, 4);
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 3u);
  EXPECT_GT(signedArea(drawing.loops[0].points), 0.0);
  for (int i : {1, 2}) {
    EXPECT_EQ(drawing.loops[i].kind, LoopKind::kHole);
    EXPECT_LT(signedArea(drawing.loops[i].points), 0.0);
  }
}

TEST_F(DxfReader, PutsTheOuterLoopFirst) {
  DxfWriter dxf;
  dxf.circle(10, 10, 3).rectangle(0, 0, 20, 20);
  const Drawing drawing = load(dxf);
  EXPECT_TRUE(boxNear(drawing.loops.at(0), 0, 0, 20, 20));
  EXPECT_TRUE(boxNear(drawing.loops.at(1), 7, 7, 13, 13));
}

TEST_F(DxfReader, KeepsChordsCloseToCircles) {
  for (const double radius : {1.0, 20.0, 400.0}) {
    EXPECT_LE(worstOffCircle(load(DxfWriter().circle(3, -5, radius)).loops.at(0), 3, -5, radius),
              kChordMm);
  }
}

TEST_F(DxfReader, ReadsArcs) {
  DxfWriter dxf;  // a D: the arc runs through 0 degrees
  dxf.arc(0, 0, 10, 270, 90).line(0, 10, 0, -10);
  const Drawing drawing = load(dxf);
  EXPECT_TRUE(boxNear(drawing.loops.at(0), 0, -10, 10, 10));
  EXPECT_NEAR(signedArea(drawing.loops[0].points), 50e-6 * kPi, 32e-6 * kChordMm);
}

TEST_F(DxfReader, ReadsEllipses) {
  const Eigen::Vector2d major(30.0 * std::cos(0.5), 30.0 * std::sin(0.5));
  DxfWriter dxf;
  dxf.entity(
      "ELLIPSE", "CUT",
      {{10, 4}, {20, 5}, {11, major.x()}, {21, major.y()}, {40, 0.4}, {41, 0}, {42, 2 * kPi}});
  const Loop loop = load(dxf).loops.at(0);
  // Distance from the ellipse, to first order, is the implicit function over its gradient.
  const double off = worst(loop, [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d q = Eigen::Rotation2Dd(-0.5) * (p - Eigen::Vector2d(4, 5));
    const Eigen::Vector2d gradient(2 * q.x() / 900, 2 * q.y() / 144);
    return (q.x() * q.x() / 900 + q.y() * q.y() / 144 - 1) / gradient.norm();
  });
  EXPECT_LE(off, 1.01 * kChordMm);
}

TEST_F(DxfReader, ReadsBulges) {
  DxfWriter dxf;  // a slot, from half circles
  dxf.polyline({{0, 0}, {20, 0, 1.0}, {20, 10}, {0, 10, 1.0}});
  const Loop slot = load(dxf).loops.at(0);
  EXPECT_TRUE(boxNear(slot, -5, 0, 25, 10));
  EXPECT_NEAR(signedArea(slot.points), (200 + 25 * kPi) * 1e-6, 72e-6 * kChordMm);
  dxf = DxfWriter();  // one end bulges inward, by a quarter circle
  dxf.polyline({{0, 0}, {20, 0, -std::tan(kPi / 8)}, {20, 10}, {0, 10}});
  EXPECT_TRUE(boxNear(load(dxf).loops.at(0), 0, 0, 20, 10));
  EXPECT_NEAR(signedArea(load(dxf).loops.at(0).points), (200 - 50 * (kPi / 4 - 0.5)) * 1e-6,
              72e-6 * kChordMm);
}

TEST_F(DxfReader, TakesRoundingNoiseInBulgesForStraight) {
  const auto slot = [this](double noise) {
    DxfWriter dxf;
    return load(dxf.polyline({{113.37, 71.913, noise},
                              {170.97679, 89.732868, -noise},
                              {158.949118, 128.615064, noise},
                              {101.342328, 110.795195}}))
        .loops.at(0);
  };
  for (const double noise : {2e-16, 1e-13, 1e-11, 1e-9, 1e-7, 1e-300})
    EXPECT_EQ(slot(noise).points, slot(0.0).points) << noise;
  EXPECT_GT(slot(1e-3).points.size(), 4u);
}

TEST_F(DxfReader, ReadsNearlyFullBulges) {
  DxfWriter dxf;  // a circle of radius 10 but for a chord of 0.02
  const double turn = 2 * kPi - 2 * std::asin(0.001);
  dxf.polyline({{-0.01, -10, -std::tan(turn / 4)}, {0.01, -10}});
  const Loop loop = load(dxf).loops.at(0);
  EXPECT_LE(worstOffCircle(loop, 0, -10 + std::sqrt(100 - 1e-4), 10), 2.1 * kChordMm);
}

TEST_F(DxfReader, TakesEqualAnglesForNoArc) {
  const auto part = [this](double start, double end) {
    DxfWriter dxf = DxfWriter().rectangle(0, 0, 60, 40).arc(30, 20, 8, start, end);
    return load(dxf);
  };
  EXPECT_EQ(part(90, 90).loops.size(), 1u);
  EXPECT_EQ(part(90, 90).left_out, std::vector<std::string>{"ARC without length: 1 entity"});
  EXPECT_EQ(part(0, 360).loops.size(), 2u);
  EXPECT_EQ(part(-90, 270).loops.size(), 2u);
  EXPECT_EQ(part(90, 810).loops.size(), 2u);
  EXPECT_EQ(part(360, 0).loops.size(), 2u);
  DxfWriter ellipse = DxfWriter().rectangle(0, 0, 60, 40);
  ellipse.entity("ELLIPSE", "CUT",
                 {{10, 30}, {20, 20}, {11, 8}, {40, 0.5}, {41, 0}, {42, 6.28318530718}});
  EXPECT_EQ(load(ellipse).loops.size(), 2u);
}

TEST_F(DxfReader, ReadsOldPolylinesAsTheyCome) {
  DxfWriter dxf;  // without SEQEND, of vertices without y or on other layers, wide and raised
  dxf.entity("POLYLINE", "CUT",
             {{66, 1}, {70, 1}, {40, 0.5}, {41, 0.5}, {10, 0}, {20, 0}, {30, 7}});
  dxf.entity("VERTEX", "DIM", {{10, 0}}).entity("VERTEX", "CUT", {{10, 20}, {40, 2}});
  dxf.entity("VERTEX", "CUT", {{10, 20}, {20, 10}, {30, 3}}).entity("VERTEX", "CUT", {{20, 10}});
  dxf.circle(10, 5, 2);
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 2u);
  EXPECT_TRUE(boxNear(drawing.loops[0], 0, 0, 20, 10));
  DxfWriter behind;  // flat ones may be seen from behind, three-dimensional ones not
  for (const int flags : {1, 9}) {
    behind.entity("POLYLINE", "CUT", {{70, flags}, {230, -1}});
    for (const auto& [x, y] : std::vector<std::pair<int, int>>{{10, 10}, {20, 10}, {20, 20}})
      behind.entity("VERTEX", "CUT", {{10, x}, {20, y}});
    behind.entity("SEQEND", "CUT", {});
  }
  const Drawing both = load(behind.rectangle(-50, 0, 50, 40));
  EXPECT_TRUE(boxNear(both.loops.at(1), -20, 10, -10, 20));
  EXPECT_TRUE(boxNear(both.loops.at(2), 10, 10, 20, 20));
  EXPECT_TRUE(refused(DxfWriter()
                          .entity("POLYLINE", "CUT", {{70, 1}})
                          .entity("VERTEX", "CUT", {{10, "x"}})
                          .entity("SEQEND", "CUT", {}),
                      {"POLYLINE", "CUT", "\"x\"", "VERTEX"}));
}

TEST_F(DxfReader, ReadsOldPolylines) {
  DxfWriter dxf;
  dxf.entity("POLYLINE", "CUT", {{66, 1}, {70, 1}});
  dxf.entity("VERTEX", "CUT", {{10, 0}, {20, 0}})
      .entity("VERTEX", "CUT", {{10, 20}, {20, 0}, {42, 1}});
  dxf.entity("VERTEX", "CUT", {{10, 20}, {20, 10}});
  dxf.entity("VERTEX", "CUT", {{10, 50}, {20, 50}, {70, 16}});  // the frame of a spline fit
  dxf.entity("VERTEX", "CUT", {{10, 0}, {20, 10}}).entity("SEQEND", "CUT", {});
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 1u);
  EXPECT_TRUE(boxNear(drawing.loops[0], 0, 0, 25, 10));
}

DxfGroups splineGroups(int flags, int degree, const std::vector<double>& knots,
                       const std::vector<Eigen::Vector2d>& control,
                       const std::vector<double>& weights = {}) {
  DxfGroups groups = {{70, flags},
                      {71, degree},
                      {72, static_cast<int>(knots.size())},
                      {73, static_cast<int>(control.size())}};
  for (const double knot : knots) groups.emplace_back(40, knot);
  for (std::size_t i = 0; i < control.size(); ++i) {
    groups.emplace_back(10, control[i].x());
    groups.emplace_back(20, control[i].y());
    groups.emplace_back(30, 0.0);
    if (!weights.empty()) groups.emplace_back(41, weights[i]);
  }
  return groups;
}

TEST_F(DxfReader, ReadsRationalSplines) {
  // The circle as a NURBS: exact only if the weights are honoured.
  const double w = std::sqrt(0.5);
  const std::vector<Eigen::Vector2d> control = {
      {30, 0}, {30, 30}, {0, 30}, {-30, 30}, {-30, 0}, {-30, -30}, {0, -30}, {30, -30}, {30, 0}};
  DxfWriter dxf;
  dxf.entity("SPLINE", "CUT",
             splineGroups(5, 2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, control,
                          {1, w, 1, w, 1, w, 1, w, 1}));
  EXPECT_LE(worstOffCircle(load(dxf).loops.at(0), 0, 0, 30), kChordMm);
}

TEST_F(DxfReader, ReadsPeriodicSplines) {
  // Uniform knots without clamped ends: at each knot the curve is at (a + 4 b + c) / 6.
  std::vector<Eigen::Vector2d> control;
  for (int i = 0; i < 8 + 3; ++i)
    control.emplace_back(40 * std::cos(i * kPi / 4), 25 * std::sin(i * kPi / 4));
  std::vector<double> knots;
  for (int i = 0; i < 8 + 3 + 4; ++i) knots.push_back(i);
  DxfWriter dxf;
  dxf.entity("SPLINE", "CUT", splineGroups(3, 3, knots, control));
  const Loop loop = load(dxf).loops.at(0);
  EXPECT_TRUE(loop.closed);
  const double share = (4 + 2 * std::cos(kPi / 4)) / 6;
  EXPECT_TRUE(boxNear(loop, -40 * share, -25 * share, 40 * share, 25 * share));
}

TEST_F(DxfReader, RefusesSplinesThatDoNotFit) {
  EXPECT_TRUE(refused(
      DxfWriter().entity("SPLINE", "CUT",
                         splineGroups(0, 3, {0, 0, 1, 1}, {{0, 0}, {1, 1}, {2, 0}, {3, 1}})),
      {"SPLINE", "CUT", "4 knots", "need 8"}));
  EXPECT_TRUE(refused(DxfWriter().entity("SPLINE", "CUT",
                                         splineGroups(0, 3, {0, 0, 0, 0, 1, 1, 1, 0.5},
                                                      {{0, 0}, {1, 1}, {2, 0}, {3, 1}})),
                      {"SPLINE", "ascend"}));
}

DxfGroups fitGroups(int flags, const std::vector<Eigen::Vector2d>& points) {
  DxfGroups groups = {{70, flags}, {71, 3}, {74, static_cast<int>(points.size())}};
  for (const Eigen::Vector2d& p : points)
    groups.insert(groups.end(), {{11, p.x()}, {21, p.y()}, {31, 0.0}});
  return groups;
}

TEST_F(DxfReader, InterpolatesFitPoints) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 16; ++i)
    points.emplace_back(20 * std::cos(i * kPi / 8), 20 * std::sin(i * kPi / 8));
  DxfWriter closed;
  closed.entity("SPLINE", "CUT", fitGroups(1, points));
  // A cubic spline through 16 points of a circle is off it by some microns.
  EXPECT_LE(worstOffCircle(load(closed).loops.at(0), 0, 0, 20), kChordMm + 0.01);

  DxfWriter open;  // half of it, with the tangents at its ends, closed by a line
  DxfGroups half = fitGroups(0, {points.begin(), points.begin() + 9});
  half.insert(half.end(), {{12, 0.0}, {22, 1.0}, {32, 0.0}, {13, 0.0}, {23, -1.0}, {33, 0.0}});
  open.entity("SPLINE", "CUT", half).line(-20, 0, 20, 0);
  EXPECT_TRUE(boxNear(load(open).loops.at(0), -20, 0, 20, 20));
}

TEST_F(DxfReader, ForgetsOneSplineBeforeTheNext) {
  DxfWriter dxf;  // counts that a file leaves out are not those of the entity before
  dxf.entity("SPLINE", "CUT", fitGroups(1, {{0, 0}, {40, 0}, {40, 40}, {0, 40}}));
  dxf.entity("SPLINE", "CUT",
             splineGroups(5, 1, {0, 0, 1, 2, 3, 4, 4},
                          {{10, 10}, {20, 10}, {20, 20}, {10, 20}, {10, 10}}));
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 2u);
  EXPECT_TRUE(boxNear(drawing.loops[1], 10, 10, 20, 20));
}

TEST_F(DxfReader, MirrorsEntitiesSeenFromBehind) {
  DxfWriter dxf;  // extrusion (0, 0, -1): x of arcs, circles and polylines points left
  dxf.entity("LWPOLYLINE", "CUT",
             {{90, 4},
              {70, 1},
              {10, 0},
              {20, 0},
              {10, 30},
              {20, 0},
              {42, 1.0},
              {10, 30},
              {20, 20},
              {10, 0},
              {20, 20},
              {210, 0},
              {220, 0},
              {230, -1}});
  dxf.entity("CIRCLE", "CUT", {{10, 25}, {20, 10}, {40, 5}, {230, -1}});
  dxf.entity("ARC", "CUT", {{10, 8}, {20, 10}, {40, 4}, {50, 0}, {51, 90}, {230, -1}});
  dxf.line(-12, 10, -8, 10).line(-8, 10, -8, 14);  // lines have world coordinates
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 3u);
  EXPECT_TRUE(boxNear(drawing.loops[0], -40, 0, 0, 20));
  EXPECT_TRUE(boxNear(drawing.loops[1], -30, 5, -20, 15));
  EXPECT_TRUE(boxNear(drawing.loops[2], -12, 10, -8, 14));
}

TEST_F(DxfReader, MirrorsHalfEllipsesSeenFromBehind) {
  DxfWriter dxf;  // the minor axis is normal x major: here it points down
  dxf.entity("ELLIPSE", "CUT",
             {{10, 0}, {20, 0}, {11, 20}, {21, 0}, {40, 0.5}, {41, 0}, {42, kPi}, {230, -1}});
  dxf.line(-20, 0, 20, 0);
  EXPECT_TRUE(boxNear(load(dxf).loops.at(0), -20, -10, 20, 0));
}

TEST_F(DxfReader, PlacesBlocks) {
  DxfWriter dxf;
  dxf.block("TAB", 5, 0).rectangle(5, 0, 15, 4, "0").endBlock();
  dxf.rectangle(-50, -50, 50, 50);
  dxf.insert("TAB", 20, 10, {{50, 90.0}}).insert("tab", -30, -30, {{41, 2.0}, {42, 3.0}});
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 3u);
  EXPECT_TRUE(boxNear(drawing.loops[1], 16, 10, 20, 20));
  EXPECT_TRUE(boxNear(drawing.loops[2], -30, -30, -10, -18));
}

TEST_F(DxfReader, MirrorsBlocksByNegativeScale) {
  DxfWriter dxf;
  dxf.block("D").arc(0, 0, 5, 270, 90, "0").line(0, 5, 0, -5, "0").endBlock();
  dxf.rectangle(-50, -50, 50, 50).insert("D", 10, 0, {{41, -1.0}});
  const Drawing drawing = load(dxf);
  EXPECT_TRUE(boxNear(drawing.loops.at(1), 5, -5, 10, 5));
  EXPECT_LT(signedArea(drawing.loops[1].points), 0.0);
}

TEST_F(DxfReader, StretchesArcsToEllipses) {
  DxfWriter dxf;
  dxf.block("HOLE").circle(0, 0, 5, "0").endBlock();
  dxf.rectangle(-50, -50, 50, 50).insert("HOLE", 0, 0, {{41, 4.0}, {42, 1.0}, {50, 90.0}});
  const Loop hole = load(dxf).loops.at(1);
  EXPECT_TRUE(boxNear(hole, -5, -20, 5, 20));
  EXPECT_NEAR(-signedArea(hole.points), 100e-6 * kPi, 85e-6 * kChordMm);
}

TEST_F(DxfReader, PlacesNestedBlocksAndArrays) {
  DxfWriter dxf;
  dxf.block("HOLE").circle(0, 0, 1, "0").endBlock();
  dxf.block("PAIR").insert("HOLE", -3, 0).insert("HOLE", 3, 0).endBlock();
  dxf.rectangle(-50, -50, 50, 50);
  dxf.insert("PAIR", -20, -20, {{41, 2.0}, {42, 2.0}, {70, 3}, {71, 2}, {44, 20.0}, {45, 30.0}});
  const Drawing drawing = load(dxf);
  ASSERT_EQ(count(drawing, LoopKind::kHole), 12);  // 2 x 3 columns x 2 rows
  EXPECT_TRUE(boxNear(drawing.loops[1], -28, -22, -24, -18));
  EXPECT_TRUE(boxNear(drawing.loops[12], 24, 8, 28, 12));
}

TEST_F(DxfReader, MirrorsInsertsSeenFromBehind) {
  DxfWriter dxf;
  dxf.block("TAB").rectangle(0, 0, 10, 4, "0").endBlock();
  dxf.rectangle(-50, -50, 50, 50).insert("TAB", 20, 10, {{230, -1}});
  EXPECT_TRUE(boxNear(load(dxf).loops.at(1), -30, 10, -20, 14));
}

TEST_F(DxfReader, RefusesBrokenBlocks) {
  EXPECT_TRUE(refused(DxfWriter().insert("NONE", 0, 0), {"INSERT", "NONE", "not in the file"}));
  DxfWriter loop;
  loop.block("A").insert("A", 1, 1).endBlock().insert("A", 0, 0);
  EXPECT_TRUE(refused(loop, {"INSERT", "\"A\"", "contains itself"}));
  DxfWriter many;
  many.block("A").circle(0, 0, 1).endBlock().insert("A", 0, 0, {{70, 32000}, {71, 32000}});
  EXPECT_TRUE(refused(many, {"INSERT", "repeats"}));
}

}  // namespace
}  // namespace planar_bin_picking
