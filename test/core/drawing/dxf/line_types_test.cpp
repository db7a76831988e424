// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/line_types.h"

#include "support/drawing_fixture.h"

namespace planar_bin_picking {
namespace {

class LineTypes : public DrawingTest {
 protected:
  /// A plate with a circle of this line type in it.
  Drawing circle(const std::string& linetype, DxfWriter dxf = DxfWriter()) {
    dxf.rectangle(0, 0, 60, 40);
    return load(dxf.entity("CIRCLE", "CUT", {{6, linetype}, {10, 30}, {20, 20}, {40, 8}}));
  }
};

TEST_F(LineTypes, OfAnnotationAreKnownInManyLanguages) {
  for (const char* name :
       {"CENTER",        "center2",        "CENTRE",         "HIDDENX2",    "DASHED",
        "DASHDOT",       "DOT2",           "DIVIDE",         "BORDER2",     "PHANTOM",
        "AXES",          "ACAD_ISO02W100", "ACAD_ISO10W100", "ISO07W100",   "JIS_02_0.7",
        "JIS_08_11",     "JIS_09_29",      "SLD-Center",     "Chain",       "MITTE",
        "MITTE2",        "STRICHPUNKT",    "STRICHLINIE",    "GESTRICHELT", "VERDECKT2",
        "PUNKT",         "RAND",           "TRAIT_MIXTE",    "TRAITS",      "MIXTE",
        "AXE",           "AXES",           "TIRETS",         "POINTILLE",   "CACHE",
        "CACHÉ",         "INTERROMPU",     "CENTRO",         "OCULTA",      "TRAZOS",
        "TRAZO_Y_PUNTO", "TRATTEGGIATA",   "NASCOSTA",       "ASSE",        "HARTLIJN",
        "STREEPLIJN",    "KRESKOWA",       "OSIOWA",         "ČÁRKOVANÁ",   "čerchovaná",
        "PRZERYWANA",    "přerušovaná",    "ОСЕВАЯ",         "штриховая"}) {
    const Drawing drawing = circle(name);
    EXPECT_EQ(drawing.loops.size(), 1u) << name;
    EXPECT_EQ(drawing.left_out,
              std::vector<std::string>{"line type " + std::string(name) + ": 1 entity"});
  }
}

TEST_F(LineTypes, OfEdgesAreReadWithoutAWord) {
  for (const char* name : {"CONTINUOUS", "Continuous", "BYLAYER", "ByBlock", "SOLID", "SLD-Solid",
                           "AUSGEZOGEN", "KONTINUIERLICH", "ACAD_ISO01W100", "JIS_01", "CONTINU"}) {
    const Drawing drawing = circle(name);
    EXPECT_EQ(drawing.loops.size(), 2u) << name;
    EXPECT_TRUE(drawing.warnings.empty()) << name;
  }
}

TEST_F(LineTypes, AreJudgedByTheirPattern) {
  DxfWriter table;
  table.lineType("LTYPE7", {3.0, -1.0}).lineType("DOTS", {0.0}).lineType("FULL", {});
  table.lineType("LONG", {5.0}).lineType("CENTER", {}).lineType("SOLID", {1.0, -1.0});
  EXPECT_EQ(circle("ltype7", table).loops.size(), 1u);
  EXPECT_EQ(circle("DOTS", table).loops.size(), 1u);
  EXPECT_EQ(circle("SOLID", table).loops.size(), 1u);   // whatever it is called
  EXPECT_EQ(circle("CENTER", table).loops.size(), 1u);  // its name alone says it
  for (const char* name : {"FULL", "LONG"}) {
    EXPECT_EQ(circle(name, table).loops.size(), 2u) << name;
    EXPECT_TRUE(circle(name, table).warnings.empty()) << name;
  }
}

TEST_F(LineTypes, ThatNobodyKnowsAreDoubted) {
  const Drawing drawing = circle("XYZZY");
  EXPECT_EQ(drawing.loops.size(), 2u);
  EXPECT_TRUE(says(drawing.warnings, {"line type XYZZY: 1 entity", "edges"}));
}

TEST_F(LineTypes, ComeFromLayersAndBlocks) {
  DxfWriter dxf;
  dxf.layer("AXES", 7, 0, "MITTE").rectangle(0, 0, 60, 40).circle(30, 20, 8, "AXES");
  EXPECT_EQ(load(dxf).left_out, std::vector<std::string>{"line type MITTE: 1 entity"});
  DxfWriter block;
  block.rectangle(0, 0, 60, 40).block("B");
  block.entity("CIRCLE", "0", {{6, "BYBLOCK"}, {40, 3}}).endBlock();
  block.insert("B", 10, 10, {{6, "DOT"}}).insert("B", 40, 20);
  EXPECT_EQ(load(block).loops.size(), 2u);
}

TEST_F(LineTypes, OfNeighboursAreToldApart) {
  const DxfFile file;
  EXPECT_EQ(meaningOf("PHANTOM2", file), LineMeaning::kNeighbour);
  EXPECT_EQ(meaningOf("ACAD_ISO05W100", file), LineMeaning::kNeighbour);
  EXPECT_EQ(meaningOf("DASHED", file), LineMeaning::kAnnotation);
  EXPECT_EQ(meaningOf("", file), LineMeaning::kEdge);
  EXPECT_EQ(meaningOf("what", file), LineMeaning::kUnknown);
  DxfFile defined;
  defined.dashed_linetypes = {{"PHANTOM", true}, {"WHAT", true}, {"WHERE", false}};
  EXPECT_EQ(meaningOf("Phantom", defined), LineMeaning::kNeighbour);
  EXPECT_EQ(meaningOf("what", defined), LineMeaning::kAnnotation);
  EXPECT_EQ(meaningOf("where", defined), LineMeaning::kEdge);
}

}  // namespace
}  // namespace planar_bin_picking
