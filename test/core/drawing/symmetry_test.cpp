// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/drawing/symmetry.h"

#include "support/drawing_fixture.h"
#include "support/slow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <random>

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

/// A part of known symmetry: one sector drawn at random, and its turns about the centre.
class RandomPart {
 public:
  RandomPart(unsigned seed, const Eigen::Vector2d& center) : random_(seed), center_(center) {
    order = std::uniform_int_distribution<int>(1, 24)(random_);
    mirror = random_() % 2 == 0;
    axis = uniform(0.0, 2.0 * kPi);
    addLoop(LoopKind::kOuter, sector(5, 0.030, 0.045), true);
    const Eigen::Vector2d hole = turned(0.3 * pitch(), 0.022);
    addHole(hole, 0.0006 + 0.0002 * (order % 3), 40);
    addHole(turned(0.2 * pitch(), 0.015), 0.0009, 3);
  }

  Drawing drawing;
  int order = 1;
  bool mirror = false;
  double axis = 0.0;

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double pitch() const { return 2.0 * kPi / order; }
  static Eigen::Vector2d turned(double angle, double radius) {
    return radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }

  /// Points of one pitch by angle, from the axis on; mirrored within the pitch where the part is.
  std::vector<Eigen::Vector2d> sector(int count, double low, double high) {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < count; ++i) {
      const double share = (i + uniform(0.1, 0.9)) / count * (mirror ? 0.5 : 1.0);
      points.push_back(turned(share * pitch(), uniform(low, high)));
    }
    for (int i = count - 1; mirror && i >= 0; --i)
      points.push_back(
          turned(pitch() - std::atan2(points[i].y(), points[i].x()), points[i].norm()));
    return points;
  }
  /// The turns of the points as one loop, or each as a loop of its own.
  void addLoop(LoopKind kind, const std::vector<Eigen::Vector2d>& points, bool as_one) {
    Loop loop;
    loop.kind = kind;
    for (int k = 0; k < order; ++k) {
      const Eigen::Rotation2Dd turn(axis + k * pitch());
      for (const auto& p : points) loop.points.push_back(center_ + turn * p);
      if (as_one && k + 1 < order) continue;
      drawing.loops.push_back(loop);
      loop.points.clear();
    }
  }
  /// Of 40 corners it is a circle, of three it points somewhere.
  void addHole(const Eigen::Vector2d& middle, double radius, int corners) {
    std::vector<Eigen::Vector2d> points, mirrored;
    for (int i = 0; i < corners; ++i) {
      const Eigen::Vector2d p = middle + turned(-0.4 - 2.0 * kPi * i / corners, radius);
      points.push_back(p);
      mirrored.insert(mirrored.begin(), {p.x(), -p.y()});
    }
    addLoop(LoopKind::kHole, points, false);
    if (mirror) addLoop(LoopKind::kHole, mirrored, false);
  }

  std::mt19937 random_;
  Eigen::Vector2d center_;
};

TEST(Symmetry, OfRandomPartsIsWhatTheyWereMadeWith) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const RandomPart part(seed, {0.1, -0.2});
    const Symmetry symmetry = findSymmetry(part.drawing);
    EXPECT_EQ(symmetry.order, part.order) << seed;
    EXPECT_EQ(symmetry.mirror, part.mirror) << seed;
    if (part.mirror) {
      EXPECT_TRUE(isAxis(symmetry, part.axis, part.order)) << seed;
    }
  }
}

TEST(Symmetry, IsTheSameFarFromTheOrigin) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const RandomPart near(seed, {0.0, 0.0}), far(seed, {8e3, -7e3});  // 10 km
    const Symmetry expected = findSymmetry(near.drawing), symmetry = findSymmetry(far.drawing);
    EXPECT_EQ(symmetry.order, expected.order) << seed;
    EXPECT_EQ(symmetry.mirror, expected.mirror) << seed;
    EXPECT_LT(axisDifference(symmetry.mirror_axis, expected.mirror_axis), 1e-6) << seed;
    EXPECT_LT((symmetry.center - Eigen::Vector2d(8e3, -7e3) - expected.center).norm(), 1e-7);
  }
}

TEST(Symmetry, OneHoleOutOfPlaceBreaksIt) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    RandomPart part(seed, {0.0, 0.0});
    if (part.order < 3) continue;
    Drawing drawing = part.drawing;
    Loop& hole = drawing.loops[1 + seed % (drawing.loops.size() - 1)];
    for (auto& p : hole.points) p += Eigen::Vector2d(0.15e-3, 0.1e-3);
    const Symmetry symmetry = findSymmetry(drawing);
    EXPECT_EQ(symmetry.order, 1) << seed;
    // One of another size, at the right place.
    drawing = part.drawing;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const auto& p : drawing.loops[1].points) middle += p / drawing.loops[1].points.size();
    for (auto& p : drawing.loops[1].points) p = middle + 1.5 * (p - middle);
    EXPECT_EQ(findSymmetry(drawing).order, 1) << seed;
  }
}

TEST(Symmetry, AShallowFlatOfADiskIsItsAxis) {
  Drawing drawing;
  Loop loop;
  const Eigen::Rotation2Dd turn(0.7);
  for (int i = 0; i < 720; ++i) {
    const double angle = 2.0 * kPi * i / 720;
    loop.points.push_back(
        turn * Eigen::Vector2d(std::min(0.05 * std::cos(angle), 0.0498), 0.05 * std::sin(angle)));
  }
  drawing.loops.push_back(loop);
  EXPECT_EQ(findSymmetry(drawing).order, 1);
  EXPECT_TRUE(isAxis(findSymmetry(drawing), 0.7, 1));
}

/// Round holes are compared by their centres; what only looks like them is not.
TEST(Symmetry, ARoundHoleMayBeDrawnInAnyWay) {
  Drawing drawing;
  const auto add = [&](LoopKind kind, double x, double y, double radius, int corners, double turn) {
    Loop loop;
    loop.kind = kind;
    for (int i = 0; i < corners; ++i) {
      const double angle = turn + 2.0 * kPi * i / corners;
      loop.points.emplace_back(x + radius * std::cos(angle), y + radius * std::sin(angle));
    }
    drawing.loops.push_back(loop);
  };
  add(LoopKind::kOuter, 0, 0, 0.040, 6, 0.0);
  add(LoopKind::kHole, 0.02, 0, 0.004, 90, 0.0);
  add(LoopKind::kHole, -0.02, 0, 0.004, 71, 0.3);
  EXPECT_EQ(findSymmetry(drawing).order, 2);
  drawing.loops.pop_back();
  add(LoopKind::kHole, -0.02, 0, 0.004, 8, 0.3);  // an octagon is off by 0.3 mm
  EXPECT_EQ(findSymmetry(drawing).order, 1);
  drawing.loops.pop_back();
  // Too coarse for a circle, but its corners and sides lie within the tolerance of one.
  add(LoopKind::kHole, -0.02, 0, 0.004, 26, 0.3);
  EXPECT_EQ(findSymmetry(drawing).order, 2);
}

TEST(Symmetry, OfThousandsOfHolesIsFoundInNoTime) {
  for (const int across : {32, 55}) {  // 1024 and 3025 holes
    Drawing drawing;
    const double side = 4e-3 * across;
    drawing.loops.push_back({LoopKind::kOuter, true, {{0, 0}, {side, 0}, {side, side}, {0, side}}});
    for (int i = 0; i < across * across; ++i) {
      Loop hole;
      hole.kind = LoopKind::kHole;
      for (int k = 0; k < 32; ++k) {
        const double angle = -2.0 * kPi * k / 32;
        hole.points.emplace_back(4e-3 * (0.5 + i % across) + 1.5e-3 * std::cos(angle),
                                 4e-3 * (0.5 + i / across) + 1.5e-3 * std::sin(angle));
      }
      drawing.loops.push_back(hole);
    }
    const std::clock_t start = std::clock();
    EXPECT_EQ(findSymmetry(drawing).order, 4);
    // Of the process, so that others on the machine do not count.
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, kSlow * 0.5) << across;
    drawing.loops.back().points.front() += Eigen::Vector2d(0.3e-3, 0.0);
    EXPECT_EQ(findSymmetry(drawing).order, 1);
  }
}

TEST(Symmetry, RefusesADrawingWithoutOutline) {
  EXPECT_TRUE(refuses([] { findSymmetry(Drawing()); }, {"no outline"}));
}

}  // namespace
}  // namespace planar_bin_picking
