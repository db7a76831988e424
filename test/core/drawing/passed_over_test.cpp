// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "support/drawing_fixture.h"

namespace planar_bin_picking {
namespace {

using PassedOverTest = DrawingTest;

DxfWriter& lines(DxfWriter& dxf, double x0, double y0, double x1, double y1,
                 const std::string& layer) {
  return dxf.line(x0, y0, x1, y0, layer)
      .line(x1, y0, x1, y1, layer)
      .line(x1, y1, x0, y1, layer)
      .line(x0, y1, x0, y0, layer);
}

TEST_F(PassedOverTest, OutlinesAreNotLostByDefault) {
  for (const char* layer : {"BORDER", "DIM_OUTLINE", "TITLE", "TEXT", "CENTERED", "Defpoints"}) {
    EXPECT_TRUE(refused(DxfWriter().rectangle(0, 0, 60, 40, layer).circle(30, 20, 8, "HOLES"),
                        {std::string("layer ") + layer, "(60.000, 40.000) mm", "keep_layers"}));
    DxfWriter two;  // not: "several outer contours"
    two.circle(20, 20, 5, "HOLES").circle(40, 20, 5, "HOLES");
    EXPECT_TRUE(refused(lines(two, 0, 0, 60, 40, layer), {std::string("layer ") + layer}));
    DxfWriter block;
    block.block("B").rectangle(0, 0, 60, 40, "0").endBlock().insert("B", 0, 0, {}, layer);
    EXPECT_TRUE(refused(block.circle(20, 20, 5), {std::string("layer ") + layer}));
  }
}

TEST_F(PassedOverTest, LayersThatAreNamedAreMeant) {
  const DxfWriter dxf = DxfWriter().rectangle(0, 0, 60, 40, "BORDER").circle(30, 20, 8, "HOLES");
  DrawingParams skip;
  skip.skip_layers = {"BORDER"};
  EXPECT_TRUE(boxNear(load(dxf, skip).loops.at(0), 22, 12, 38, 28));
  EXPECT_TRUE(load(dxf, skip).warnings.empty());
  DrawingParams keep;
  keep.keep_layers = {"BORDER", "HOLES"};
  keep.skip_layers.clear();
  EXPECT_EQ(load(dxf, keep).loops.size(), 2u);
}

TEST_F(PassedOverTest, FramesAreFrames) {
  // Around a part with a hole, it can be nothing else.
  DxfWriter dxf = DxfWriter().rectangle(0, 0, 60, 40).circle(30, 20, 8);
  EXPECT_TRUE(load(dxf.rectangle(-100, -100, 200, 150, "BORDER")).warnings.empty());
  // Around one without: if it is a rectangle and has a title block, or words.
  DxfWriter block = DxfWriter().rectangle(0, 0, 60, 40);
  lines(block, -100, -100, 200, 150, "TITLE").line(100, -100, 100, -50, "TITLE");
  EXPECT_TRUE(says(load(block).warnings, {"layer TITLE", "around the part"}));
  DxfWriter words = DxfWriter().rectangle(0, 0, 60, 40).rectangle(-100, -100, 200, 150, "BORDER");
  EXPECT_TRUE(refused(words, {"BORDER"}));
  words.entity("TEXT", "BORDER", {{1, "A3"}});
  EXPECT_TRUE(says(load(words).warnings, {"layer BORDER", "(200.000, 150.000) mm"}));
  DxfWriter round = DxfWriter().rectangle(0, 0, 60, 40).circle(30, 20, 90, "BORDER");
  EXPECT_TRUE(refused(round.entity("TEXT", "BORDER", {{1, "A3"}}), {"layer BORDER"}));
}

TEST_F(PassedOverTest, LargerContoursBesideThePartAreReported) {
  const DxfWriter dxf = DxfWriter().rectangle(0, 0, 60, 40).circle(30, 20, 8);
  EXPECT_TRUE(says(load(DxfWriter(dxf).rectangle(70, 0, 140, 40, "TITLE")).warnings,
                   {"layer TITLE", "(140.000, 40.000) mm", "larger than the part"}));
  EXPECT_TRUE(load(DxfWriter(dxf).rectangle(70, 0, 120, 40, "TITLE")).warnings.empty());
}

TEST_F(PassedOverTest, HolesAreReported) {
  DxfWriter dxf = DxfWriter().rectangle(0, 0, 60, 40).circle(30, 20, 3);
  dxf.circle(10, 10, 2, "DIM_A").circle(50, 10, 2, "DIM_A").rectangle(40, 30, 45, 35, "TEXT");
  const Drawing drawing = load(dxf);
  EXPECT_EQ(drawing.loops.size(), 2u);
  EXPECT_TRUE(says(drawing.warnings, {"layer DIM_A: 2 closed contours", "keep_layers"}));
  EXPECT_TRUE(says(drawing.warnings, {"layer TEXT: 1 closed contour "}));
  EXPECT_EQ(drawing.warnings.size(), 2u);
}

TEST_F(PassedOverTest, WhatIsNoHoleIsNot) {
  DxfWriter dxf =
      DxfWriter().rectangle(0, 0, 60, 40).circle(30, 20, 5).layer("CENTER", 7, 0, "CENTER");
  dxf.circle(30, 20, 2, "DIM").circle(30, 20, 8, "DIM");   // in and around a hole
  dxf.circle(60, 20, 4, "DIM").circle(100, 20, 4, "DIM");  // across the edge, and beside
  dxf.circle(34, 20, 3, "DIM");                            // across a hole's edge
  dxf.line(5, 5, 9, 5, "DIM").line(9, 5, 9, 9, "DIM");     // open
  dxf.circle(10, 20, 3, "CENTER");                         // an axis
  dxf.layer("TITLE", -7).circle(10, 20, 3, "TITLE");       // not seen
  EXPECT_EQ(load(dxf).warnings, std::vector<std::string>());
}

TEST_F(PassedOverTest, LineTypesAroundAllAreRefusedOrReported) {
  const auto around = [](const char* linetype) {
    DxfWriter dxf;
    dxf.entity("CIRCLE", "CUT", {{6, linetype}, {10, 30}, {20, 20}, {40, 50}});
    return dxf.rectangle(20, 10, 40, 30);
  };
  EXPECT_TRUE(refused(around("DASHED"), {"line type DASHED", "keep_layers"}));
  EXPECT_TRUE(says(load(around("PHANTOM")).warnings, {"line type PHANTOM", "around the part"}));
  EXPECT_TRUE(load(around("PHANTOM").circle(30, 20, 4)).warnings.empty());
  DxfWriter inside = DxfWriter().rectangle(0, 0, 60, 40);
  inside.entity("CIRCLE", "CUT", {{6, "CENTER"}, {10, 30}, {20, 20}, {40, 5}});
  EXPECT_TRUE(load(inside).warnings.empty());
}

TEST_F(PassedOverTest, CrowdsAreNotSearched) {
  DxfWriter dxf = DxfWriter().rectangle(0, 0, 60, 40);
  for (int i = 0; i < 6000; ++i) dxf.line(0, 0, 60, 0.01 * i, "DIM");
  EXPECT_EQ(load(dxf).loops.size(), 1u);
}

}  // namespace
}  // namespace planar_bin_picking
