// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "support/drawing_fixture.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

using DrawingContours = DrawingTest;

TEST_F(DrawingContours, LeavesAnnotationOut) {
  DxfWriter dxf;
  dxf.layer("CUT")
      .layer("OFF", -7)
      .layer("ICE", 7, 1)
      .layer("AXES", 7, 0, "CENTER2")
      .layer("DIMENSIONS");
  dxf.rectangle(0, 0, 30, 20);
  dxf.line(0, 0, 100, 100, "OFF").line(0, 0, 100, 100, "ICE").line(0, 0, 100, 100, "AXES");
  dxf.line(0, 0, 100, 100, "Dimensions")
      .line(0, 0, 100, 100, "Title_Block")
      .line(0, 0, 9, 9, "BORDER");
  for (const char* linetype : {"CENTER", "Hidden2", "PHANTOM", "DASHED", "ACAD_ISO02W100"}) {
    dxf.entity("LINE", "CUT", {{6, linetype}, {10, 1}, {20, 1}, {11, 90}, {21, 7}});
  }
  dxf.entity("LINE", "CUT", {{60, 1}, {10, 1}, {20, 1}, {11, 90}, {21, 7}});  // invisible
  dxf.entity("LINE", "CUT", {{67, 1}, {10, 1}, {20, 1}, {11, 90}, {21, 7}});  // on the sheet
  dxf.entity("TEXT", "CUT", {{10, 1}, {20, 1}, {40, 5}, {1, "LINE"}});
  dxf.entity("MTEXT", "CUT", {{10, 1}, {20, 1}, {40, 5}, {1, "words"}});
  dxf.entity("POINT", "CUT", {{10, 1}, {20, 1}});
  dxf.entity("DIMENSION", "CUT", {{2, "*D1"}, {10, 1}, {20, 1}, {70, 0}});
  dxf.entity("LEADER", "CUT", {{76, 2}, {10, 1}, {20, 1}, {10, 60}, {20, 60}});
  dxf.entity("HATCH", "CUT",
             {{10, 0},
              {20, 0},
              {91, 1},
              {92, 2},
              {72, 0},
              {73, 1},
              {93, 2},
              {10, 0},
              {20, 0},
              {10, 9},
              {20, 9}});
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 1u);
  EXPECT_TRUE(boxNear(drawing.loops[0], 0, 0, 30, 20));
}

TEST_F(DrawingContours, LeavesHiddenPolylinesOutWithTheirVertices) {
  DxfWriter dxf;
  dxf.rectangle(0, 0, 30, 20).entity("POLYLINE", "CUT", {{60, 1}, {66, 1}, {70, 0}});
  dxf.entity("VERTEX", "CUT", {{10, 50}, {20, 50}})
      .entity("VERTEX", "CUT", {{10, 60}, {20, 50}})
      .entity("SEQEND", "CUT", {});
  EXPECT_EQ(load(dxf).loops.size(), 1u);
}

TEST_F(DrawingContours, BlocksTakeOverLayerAndLineType) {
  DxfWriter dxf;
  dxf.layer("AXES", 7, 0, "CENTER").layer("ICE", 7, 1).layer("OFF", -7);
  dxf.block("B").circle(0, 0, 2, "0").endBlock();
  dxf.block("C").circle(0, 0, 2, "CUT").endBlock();
  dxf.rectangle(-50, -50, 50, 50);
  dxf.insert("B", 0, 0, {}, "AXES").insert("B", 0, 0, {}, "ICE").insert("B", 0, 0, {}, "OFF");
  dxf.insert("C", 0, 0, {}, "ICE").insert("C", 0, 0, {}, "TITLE");
  dxf.insert("C", 20, 0, {},
             "OFF");  // off hides what stands on the layer, frozen hides the whole block
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 2u);
  EXPECT_TRUE(boxNear(drawing.loops[1], 18, -2, 22, 2));
}

TEST_F(DrawingContours, HonoursLayerLists) {
  DxfWriter dxf;
  dxf.rectangle(0, 0, 30, 20, "Kontur_1").circle(10, 10, 2, "Kontur_2").circle(20, 10, 2, "Hilfe");
  DrawingParams keep;
  keep.keep_layers = {"kontur*"};
  EXPECT_EQ(load(dxf, keep).loops.size(), 2u);
  DrawingParams skip;
  skip.skip_layers = {"*_2", "H*F*"};
  EXPECT_EQ(load(dxf, skip).loops.size(), 1u);
}

TEST_F(DrawingContours, TellsPrintsFromEdges) {
  DxfWriter dxf;
  dxf.rectangle(0, 0, 30, 20)
      .line(5, 5, 10, 5, "Print")
      .line(10, 5, 10, 9, "PRINT")
      .circle(20, 10, 2, "SILK");
  dxf.line(5, 15, 8, 15, "ENGRAVED").line(6, 14, 6, 16, "ENGRAVED");
  dxf.block("LOGO").line(15, 2, 18, 2, "ART").endBlock().insert("LOGO", 0, 0, {}, "PRINT");
  const Drawing drawing = load(dxf);
  EXPECT_EQ(count(drawing, LoopKind::kOuter), 1);
  ASSERT_EQ(count(drawing, LoopKind::kPrint), 5);
  EXPECT_EQ(drawing.loops[1].points.size(), 3u);  // two lines that meet
  EXPECT_FALSE(drawing.loops[1].closed);
  EXPECT_TRUE(drawing.loops[2].closed);
}

TEST_F(DrawingContours, RefusesPrintsBesideThePart) {
  DxfWriter dxf;
  dxf.rectangle(0, 0, 30, 20).line(5, 5, 45, 5, "PRINT");
  EXPECT_TRUE(refused(dxf, {"print", "LINE", "PRINT", "not on the part", "skip_layers"}));
  DxfWriter over;  // by half a stroke
  EXPECT_EQ(load(over.rectangle(0, 0, 30, 20).line(5, 5, 30.9, 5, "PRINT")).loops.size(), 2u);
  EXPECT_TRUE(refused(over.line(5, 9, 31.1, 9, "PRINT"), {"not on the part"}));
}

TEST_F(DrawingContours, RemovesLinesDrawnTwice) {
  DxfWriter dxf;
  dxf.line(0, 0, 40, 0).line(40, 0, 40, 20).line(40, 20, 0, 20).line(0, 20, 0, 0);
  dxf.line(40, 0, 0, 0).line(40.01, 0, 40.01, 20).circle(20, 10, 4).circle(20, 10, 4);
  dxf.line(10, 10, 10, 10);  // no length
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 2u);
  EXPECT_EQ(drawing.loops[0].points.size(), 4u);
}

TEST_F(DrawingContours, KeepsOutlinesOfVeryShortLines) {
  DxfWriter dxf;  // as some CAM programs export arcs: lines shorter than the join tolerance
  dxf.rectangle(-10, -10, 10, 10);
  const int n = 400;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * kPi * i / n, b = 2 * kPi * (i + 1) / n;
    dxf.line(2 * std::cos(a), 2 * std::sin(a), 2 * std::cos(b), 2 * std::sin(b));
  }
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 2u);
  EXPECT_TRUE(boxNear(drawing.loops[1], -2, -2, 2, 2));
}

TEST_F(DrawingContours, DropsSlivers) {
  DxfWriter dxf;
  dxf.line(0, 0, 40, 0).line(40, 0, 40, 20).line(40, 20, 0, 20).line(0, 20, 0, 0);
  dxf.line(40, 20, 40.03, 20).line(20, 10, 20.04, 10).circle(10, 10, 0.005);
  EXPECT_EQ(load(dxf).loops.size(), 1u);
}

TEST_F(DrawingContours, JoinsSmallGapsOnly) {
  const auto square = [](double gap) {
    DxfWriter dxf;
    return dxf.line(0, 0, 40, 0).line(40, gap, 40, 20).line(40, 20, 0, 20).line(0, 20, 0, 0);
  };
  EXPECT_NO_THROW(load(square(0.04)));
  EXPECT_TRUE(refused(square(0.3), {"open contour", "LINE", "CUT", "(40.000, 0.000) mm",
                                    "(40.000, 0.300) mm", "0.300 mm", "skip_layers"}));
}

TEST_F(DrawingContours, ConvertsUnits) {
  const auto width = [this](int insunits, double drawn) {
    return boxMm(load(DxfWriter(insunits).rectangle(0, 0, drawn, drawn)).loops.at(0)).sizes().x();
  };
  EXPECT_NEAR(width(-1, 30), 30.0, 1e-9);   // absent: millimetres
  EXPECT_NEAR(width(0, 30), 30.0, 1e-9);    // unitless: millimetres
  EXPECT_NEAR(width(1, 2), 50.8, 1e-9);     // inches
  EXPECT_NEAR(width(2, 1), 304.8, 1e-9);    // feet
  EXPECT_NEAR(width(4, 30), 30.0, 1e-9);    // millimetres
  EXPECT_NEAR(width(5, 3), 30.0, 1e-9);     // centimetres
  EXPECT_NEAR(width(6, 0.03), 30.0, 1e-9);  // metres
}

TEST_F(DrawingContours, KeepsToleranceInMillimetresWhateverTheUnit) {
  EXPECT_LE(worstOffCircle(load(DxfWriter(6).circle(0, 0, 0.05)).loops.at(0), 0, 0, 50), kChordMm);
}

TEST_F(DrawingContours, RefusesUnknownUnitsAndSizes) {
  EXPECT_TRUE(refused(DxfWriter(99).rectangle(0, 0, 9, 9), {"$INSUNITS", "99", "millimetres"}));
  EXPECT_TRUE(refused(DxfWriter(18).rectangle(0, 0, 9, 9), {"$INSUNITS", "18"}));
  EXPECT_TRUE(refused(DxfWriter(6).rectangle(0, 0, 300, 300), {"300000 mm", "$INSUNITS"}));
  EXPECT_TRUE(refused(DxfWriter(4).rectangle(0, 0, 0.3, 0.3), {"0.3 mm", "$INSUNITS"}));
}

TEST_F(DrawingContours, RefusesEmptyDrawingsAndSaysWhatWasLeftOut) {
  EXPECT_TRUE(refused(DxfWriter(), {"no outline"}));
  DxfWriter skipped;
  skipped.layer("OFF", -1).rectangle(0, 0, 9, 9, "TITLE").rectangle(0, 0, 9, 9, "OFF");
  skipped.entity("LINE", "CUT", {{6, "HIDDEN"}, {10, 0}, {20, 0}, {11, 9}, {21, 0}});
  EXPECT_TRUE(refused(skipped, {"no outline", "layer TITLE: 1 entity", "layer OFF (off): 1 entity",
                                "line type HIDDEN: 1 entity", "keep_layers"}));
}

TEST_F(DrawingContours, HaveALength) {
  Loop loop{LoopKind::kOuter, true, {{0, 0}, {3, 0}, {3, 4}}};
  EXPECT_DOUBLE_EQ(lengthOf(loop), 12.0);
  loop.closed = false;
  EXPECT_DOUBLE_EQ(lengthOf(loop), 7.0);
  EXPECT_DOUBLE_EQ(lengthOf({LoopKind::kPrint, false, {{1, 1}}}), 0.0);
}

TEST_F(DrawingContours, RefusesBranches) {
  DxfWriter dxf;
  dxf.line(0, 0, 40, 0)
      .line(40, 0, 40, 20)
      .line(40, 20, 0, 20)
      .line(0, 20, 0, 0)
      .line(40, 20, 0, 0, "RIB");
  EXPECT_TRUE(refused(dxf, {"branches", "mm", "RIB", "LINE", "skip_layers"}));
}

TEST_F(DrawingContours, RefusesSelfIntersections) {
  EXPECT_TRUE(refused(DxfWriter().polyline({{0, 0}, {40, 20}, {40, 0}, {0, 20}}),
                      {"POLYLINE", "CUT", "crosses or touches itself", "(20.000, 10.000) mm"}));
  EXPECT_TRUE(
      refused(DxfWriter().polyline({{0, 0}, {40, 0}, {40, 20}, {40, -9}}), {"touches itself"}));
  EXPECT_TRUE(refused(DxfWriter().rectangle(0, 0, 40, 20).circle(40, 10, 3, "BORE"),
                      {"cross or touch", "BORE", "CIRCLE"}));
}

TEST_F(DrawingContours, RefusesSeveralParts) {
  EXPECT_TRUE(refused(DxfWriter().rectangle(0, 0, 40, 20).rectangle(50, 0, 60, 9, "B"),
                      {"several outer contours", "\"B\"", "(50.000, 0.000) mm"}));
  // A frame around the part makes its holes islands.
  EXPECT_TRUE(refused(
      DxfWriter().rectangle(-9, -9, 90, 90, "FRAME").rectangle(0, 0, 40, 20).circle(9, 9, 3),
      {"inside a hole", "CIRCLE", "frame"}));
}

TEST_F(DrawingContours, RefusesWhatItCannotRead) {
  DxfWriter dxf;
  dxf.rectangle(0, 0, 30, 20).entity("REGION", "CUT", {{70, 1}, {1, "secret"}});
  EXPECT_TRUE(refused(dxf, {"REGION", "CUT", "explode"}));
  dxf = DxfWriter();
  dxf.rectangle(0, 0, 30, 20).entity("REGION", "TITLE", {{70, 1}});
  EXPECT_NO_THROW(load(dxf));
  dxf.entity("CIRCLE", "CUT", {{10, 0}, {20, 0}, {40, 5}, {210, 1}, {220, 0}, {230, 0}});
  EXPECT_TRUE(refused(dxf, {"CIRCLE", "CUT", "xy plane"}));
}

}  // namespace
}  // namespace planar_bin_picking
