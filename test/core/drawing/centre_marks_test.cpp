// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/centre_marks.h"

#include "support/drawing_fixture.h"

namespace planar_bin_picking {
namespace {

class CentreMarks : public DrawingTest {
 protected:
  static DxfWriter plate() { return DxfWriter().rectangle(0, 0, 60, 40).circle(30, 20, 8); }
  static DxfWriter& cross(DxfWriter& dxf, double x, double y, double size, double turn = 0.0) {
    const double c = size * std::cos(turn), s = size * std::sin(turn);
    return dxf.line(x - c, y - s, x + c, y + s).line(x + s, y - c, x - s, y + c);
  }
  testing::AssertionResult leavesMarksOut(const DxfWriter& dxf, int lines, std::size_t loops = 2) {
    const Drawing drawing = load(dxf);
    const std::vector<std::string> expected = {"centre marks: " + std::to_string(lines) +
                                               " entities"};
    if (drawing.loops.size() != loops) return testing::AssertionFailure() << drawing.loops.size();
    if (drawing.left_out != expected) return testing::AssertionFailure() << "other account";
    return testing::AssertionSuccess();
  }
};

TEST_F(CentreMarks, InHolesAreLeftOut) {
  DxfWriter inside = plate(), across = plate(), turned = plate(), touching = plate();
  EXPECT_TRUE(leavesMarksOut(cross(inside, 30, 20, 2), 2));
  EXPECT_TRUE(leavesMarksOut(cross(across, 30, 20, 11), 2));
  EXPECT_TRUE(leavesMarksOut(cross(turned, 30, 20, 3, 0.4), 2));
  EXPECT_TRUE(leavesMarksOut(cross(touching, 30, 20, 8), 2));
}

TEST_F(CentreMarks, WithGapsAreLeftOut) {
  DxfWriter dxf = plate();
  cross(dxf, 30, 20, 1).line(18, 20, 28, 20).line(32, 20, 42, 20).line(30, 8, 30, 18);
  EXPECT_TRUE(leavesMarksOut(dxf.line(30, 22, 30, 32), 6));
}

TEST_F(CentreMarks, InRowsOfHolesAreLeftOut) {
  DxfWriter dxf = DxfWriter().rectangle(0, 0, 200, 40);
  for (int i = 1; i <= 7; ++i) {
    const double x = 25.0 * i;
    cross(dxf.circle(x, 20, 8), x, 20, 1).line(x - 12, 20, x - 2, 20).line(x + 2, 20, x + 12, 20);
    dxf.line(x, 8, x, 18).line(x, 22, x, 32);
  }
  EXPECT_TRUE(leavesMarksOut(dxf, 42, 8));
}

TEST_F(CentreMarks, OfArcsAndClosedContoursAreLeftOut) {
  DxfWriter slot = DxfWriter().rectangle(0, 0, 60, 40);  // at both ends, and in its middle
  slot.polyline({{20, 15}, {40, 15, 1.0}, {40, 25}, {20, 25, 1.0}});
  cross(cross(cross(slot, 20, 20, 2), 40, 20, 2), 30, 20, 1);
  EXPECT_TRUE(leavesMarksOut(slot, 6));
  DxfWriter square = DxfWriter().rectangle(0, 0, 60, 40).rectangle(20, 10, 40, 30);
  EXPECT_TRUE(leavesMarksOut(cross(square, 30, 20, 4), 2));
  DxfWriter corner;  // a rounded corner, drawn by lines and an arc
  corner.line(0, 0, 60, 0).line(60, 0, 60, 30).arc(50, 30, 10, 0, 90).line(50, 40, 0, 40);
  corner.line(0, 40, 0, 0);
  EXPECT_TRUE(leavesMarksOut(cross(corner, 50, 30, 2), 2, 1));
}

TEST_F(CentreMarks, AreNoOtherLines) {
  DxfWriter beside = plate(), half = plate(), lopsided = plate(), aslant = plate();
  EXPECT_TRUE(refused(cross(beside, 12, 20, 2), {"open contour"}));
  EXPECT_TRUE(refused(half.line(28, 20, 32, 20), {"open contour"}));
  EXPECT_TRUE(refused(lopsided.line(28, 20, 35, 20).line(30, 18, 30, 22), {"open contour"}));
  EXPECT_TRUE(refused(aslant.line(28, 20, 32, 20).line(28, 18, 32, 22), {"open contour"}));
  DxfWriter away = plate();  // points at the center from farther away than it is long
  away.line(41, 20, 43, 20).line(17, 20, 19, 20).line(30, 31, 30, 33).line(30, 7, 30, 9);
  EXPECT_TRUE(refused(away, {"open contour"}));
  DxfWriter joined = plate();  // meets another line
  EXPECT_TRUE(refused(cross(joined, 30, 20, 2).line(32, 20, 33, 21), {"open contour"}));
}

TEST_F(CentreMarks, TakeNoEdgeAway) {
  DxfWriter dxf = DxfWriter().rectangle(-30, -30, 30, 30);  // a cross that is cut out
  dxf.polyline({{-1, -9},
                {1, -9},
                {1, -1},
                {9, -1},
                {9, 1},
                {1, 1},
                {1, 9},
                {-1, 9},
                {-1, 1},
                {-9, 1},
                {-9, -1},
                {-1, -1}});
  EXPECT_EQ(load(dxf).loops.size(), 2u);
  EXPECT_TRUE(load(dxf).left_out.empty());
}

}  // namespace
}  // namespace planar_bin_picking
