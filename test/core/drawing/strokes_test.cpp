// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/strokes.h"

#include "support/drawing_fixture.h"

#include <ctime>

namespace planar_bin_picking {
namespace {

class Strokes : public DrawingTest {
 protected:
  static Stroke stroke(const std::vector<Eigen::Vector2d>& points, bool closed = false) {
    Stroke s{"LINE", "CUT", points, closed, {}, {}};
    if (closed) s.points.push_back(points.front());
    return s;
  }
  /// Reads as a plate of 60 x 40 with a hole of radius 8, of which so much is drawn twice.
  testing::AssertionResult isPlate(const DxfWriter& dxf, int twice) {
    const Drawing drawing = load(dxf);
    const std::string text =
        "drawn twice: " + std::to_string(twice) + (twice == 1 ? " entity" : " entities");
    if (drawing.loops.size() != 2) return testing::AssertionFailure() << drawing.loops.size();
    if (std::abs(areaMm2(drawing) - (2400 - 64 * kPi)) > 0.6)
      return testing::AssertionFailure() << areaMm2(drawing);
    if (drawing.left_out != std::vector<std::string>{text})
      return testing::AssertionFailure()
             << (drawing.left_out.empty() ? "" : drawing.left_out.at(0));
    return testing::AssertionSuccess();
  }
  static DxfWriter plate() { return DxfWriter().rectangle(0, 0, 60, 40).circle(30, 20, 8); }
  static DxfWriter plateOfLines() {
    DxfWriter dxf;
    dxf.line(0, 0, 60, 0).line(60, 0, 60, 40).line(60, 40, 0, 40).line(0, 40, 0, 0);
    return dxf.circle(30, 20, 8);
  }
};

TEST_F(Strokes, DrawnTwiceAreDropped) {
  EXPECT_TRUE(isPlate(plate().rectangle(0, 0, 60, 40), 1));
  EXPECT_TRUE(isPlate(plate().polyline({{60, 40}, {60, 0}, {0, 0}, {0, 40}}), 1));  // other start
  EXPECT_TRUE(isPlate(plate().circle(30.01, 20, 8).circle(30, 20, 8), 2));
  EXPECT_TRUE(isPlate(plateOfLines().line(60, 0, 0, 0).line(60.01, 0, 60.01, 40), 2));
}

TEST_F(Strokes, DrawnTwiceInPartAreCut) {
  // A polyline over lines, whole and in part, before and after it.
  EXPECT_TRUE(isPlate(plateOfLines().rectangle(0, 0, 60, 40), 4));
  EXPECT_TRUE(isPlate(
      plate().line(0, 0, 60, 0).line(60, 0, 60, 40).line(60, 40, 0, 40).line(0, 40, 0, 0), 4));
  EXPECT_TRUE(isPlate(plate().line(10, 0, 50, 0), 1));
  EXPECT_TRUE(isPlate(plate().line(50, 0, 0, 0).line(0, 30, 0, 10), 2));
  EXPECT_TRUE(isPlate(plateOfLines().polyline({{10, 0}, {60, 0}, {60, 25}}, false), 2));
  // Lines over lines: inside, overlapping, end to end.
  EXPECT_TRUE(isPlate(plateOfLines().line(20, 0, 40, 0), 1));
  DxfWriter overlapping;
  overlapping.line(0, 0, 40, 0).line(20, 0, 60, 0).line(60, 0, 60, 40).line(60, 40, 0, 40);
  EXPECT_TRUE(isPlate(overlapping.line(0, 40, 0, 0).circle(30, 20, 8), 1));
  EXPECT_TRUE(isPlate(plateOfLines().line(0, 0, 30, 0).line(30, 0, 60, 0), 2));
  // Arcs over circles and over arcs.
  EXPECT_TRUE(isPlate(plate().arc(30, 20, 8, 20, 130), 1));
  EXPECT_TRUE(isPlate(plate().arc(30, 20, 8, 0, 180).arc(30, 20, 8, 180, 0), 2));
  DxfWriter arcs;
  arcs.rectangle(0, 0, 60, 40).arc(30, 20, 8, 0, 200).arc(30, 20, 8, 150, 360);
  EXPECT_TRUE(isPlate(arcs, 1));
}

TEST_F(Strokes, ThatOnlyMeetAreKept) {
  EXPECT_TRUE(refused(plate().line(20, 0, 20, -30), {"LINE", "open contour"}));
  EXPECT_TRUE(refused(plateOfLines().line(0, 0, 30, 20), {"open contour", "(30.000, 20.000) mm"}));
  EXPECT_TRUE(refused(plateOfLines().line(50, 0, 70, 0), {"LINE"}));  // runs on beyond the corner
  EXPECT_TRUE(refused(plate().line(0, 0.1, 60, 0.1), {"open contour"}));
}

TEST_F(Strokes, OfVeryShortLinesMayBeDrawnTwice) {
  DxfWriter dxf = DxfWriter().rectangle(-10, -10, 10, 10);
  const int n = 400;
  for (int i = 0; i < 2 * n; ++i) {
    const double a = 2 * kPi * i / n, b = 2 * kPi * (i + 1) / n;
    dxf.line(2 * std::cos(a), 2 * std::sin(a), 2 * std::cos(b), 2 * std::sin(b));
  }
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 2u);
  EXPECT_EQ(drawing.loops[1].points.size(), 400u);
  EXPECT_EQ(drawing.left_out, std::vector<std::string>{"drawn twice: 400 entities"});
}

TEST_F(Strokes, AreCountedWhenDropped) {
  const CleanStrokes clean =
      cleanStrokes({stroke({{0, 0}, {10, 0}}), stroke({{5, 5}, {5, 5}}), stroke({{0, 0}, {10, 0}}),
                    stroke({{7, 7}, {7.04, 7}}), stroke({{3, 0}, {6, 0}}),
                    stroke({{20, 0}, {30, 0}, {30, 9}}, true)},
                   0.05);
  EXPECT_EQ(clean.twice, 2u);
  EXPECT_EQ(clean.slivers, 2u);
  ASSERT_EQ(clean.strokes.size(), 4u);  // one line in three pieces, and the triangle
  EXPECT_EQ(clean.strokes[0].points.back(), Eigen::Vector2d(3, 0));
  EXPECT_EQ(clean.strokes[1].points.back(), Eigen::Vector2d(6, 0));
  EXPECT_TRUE(clean.strokes[3].closed);
}

TEST_F(Strokes, OfManyPointsAreComparedFast) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 30000; ++i)
    points.emplace_back(100 * std::cos(2 * kPi * i / 30000), 100 * std::sin(2 * kPi * i / 30000));
  std::vector<Eigen::Vector2d> turned(points.rbegin(), points.rend());
  std::rotate(turned.begin(), turned.begin() + 777, turned.end());
  const std::clock_t start = std::clock();
  EXPECT_EQ(cleanStrokes({stroke(points, true), stroke(turned, true)}, 0.05).strokes.size(), 1u);
  // Comparing all with all takes minutes; a sanitizer's build needs some seconds.
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 10.0);
}

}  // namespace
}  // namespace planar_bin_picking
