// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/edge_selection.h"

#include "support/drawing_fixture.h"

namespace planar_bin_picking {
namespace {

using Texts = std::vector<std::string>;

class EdgeSelectionTest : public DrawingTest {
 protected:
  static DxfWriter plate() { return DxfWriter().rectangle(0, 0, 60, 40); }
  static DrawingParams keeping(const std::vector<std::string>& layers) {
    DrawingParams params;
    params.keep_layers = layers;
    params.skip_layers.clear();  // as the part file does
    return params;
  }
  static DxfWriter& text(DxfWriter& dxf, const std::string& layer) {
    return dxf.entity("TEXT", layer, {{10, 1}, {20, 1}, {40, 5}, {1, "A"}});
  }
};

TEST_F(EdgeSelectionTest, AccountsForWhatIsLeftOut) {
  DxfWriter dxf = plate();
  dxf.layer("OFF", -7).layer("ICE", 7, 1);
  dxf.line(0, 0, 1, 1, "Dim")
      .line(0, 0, 1, 2, "Dim")
      .line(0, 0, 1, 1, "OFF")
      .line(0, 0, 1, 1, "ICE");
  text(text(dxf, "CUT"), "DIM");
  dxf.entity("MTEXT", "CUT", {{1, "B"}}).entity("LEADER", "CUT", {{10, 1}});
  dxf.entity("HATCH", "CUT", {{10, 1}}).entity("POINT", "CUT", {{10, 1}});
  dxf.entity("LINE", "CUT", {{6, "CENTER"}, {11, 1}}).entity("LINE", "CUT", {{60, 1}, {11, 1}});
  dxf.entity("LINE", "CUT", {{67, 1}, {11, 1}}).entity("VIEWPORT", "0", {{67, 1}});
  dxf.line(0, 0, 60, 0).line(5, 5, 5.01, 5).entity("ARC", "CUT", {{40, 5}, {50, 9}, {51, 9}});
  const Texts expected = {"ARC without length: 1 entity",
                          "POINT: 1 entity",
                          "drawn twice: 1 entity",
                          "hatches and fillings: 1 entity",
                          "invisible: 1 entity",
                          "layer DIM: 1 entity",
                          "layer Dim: 2 entities",
                          "layer ICE (frozen): 1 entity",
                          "layer OFF (off): 1 entity",
                          "line type CENTER: 1 entity",
                          "paper space: 1 entity",
                          "shorter than the join tolerance: 1 entity",
                          "text and dimensions: 3 entities"};
  EXPECT_EQ(load(dxf).left_out, expected);
  EXPECT_EQ(load(plate()).left_out, Texts());
  DxfWriter other = plate();
  EXPECT_EQ(load(other.line(0, 0, 1, 1, "HELP"), keeping({"CUT"})).left_out,
            Texts{"layer HELP: 1 entity"});
}

TEST_F(EdgeSelectionTest, IsNotRefusedForWhatIsNotShown) {
  const auto reads = [&](DxfWriter dxf) { return load(dxf).loops.size() == 1; };
  const DxfGroups broken = {{10, "x"}, {40, 1e300}, {90, 7}};
  for (const char* type :
       {"CIRCLE", "3DSOLID", "LWPOLYLINE", "SPLINE", "ELLIPSE", "INSERT", "ARC"}) {
    EXPECT_TRUE(reads(plate().entity(type, "DIM", broken))) << type;
    EXPECT_TRUE(reads(plate().layer("L", 7, 1).entity(type, "L", broken))) << type;
    EXPECT_TRUE(reads(plate().layer("L", -7).layer("L2", 7, 1).entity(type, "L2", broken))) << type;
    EXPECT_TRUE(reads(plate().block("UNUSED").entity(type, "CUT", broken).endBlock())) << type;
    DxfGroups hidden = broken, paper = broken;
    hidden.insert(hidden.begin(), {60, 1});
    paper.insert(paper.begin(), {67, 1});
    EXPECT_TRUE(reads(plate().entity(type, "CUT", hidden))) << type;
    EXPECT_TRUE(reads(plate().entity(type, "CUT", paper))) << type;
    EXPECT_TRUE(refused(plate().entity(type, "CUT", broken), {type, "CUT"})) << type;
  }
  DxfWriter tilted = plate();
  EXPECT_TRUE(reads(tilted.entity("CIRCLE", "DIM", {{40, 5}, {210, 1}, {230, 0}})));
  DxfWriter inside = plate();  // a skipped INSERT: missing, endless, repeated, external
  inside.block("A").insert("A", 1, 1).endBlock().block("X", 0, 0, 4, "a.dwg").endBlock();
  inside.insert("NONE", 0, 0, {}, "DIM").insert("A", 0, 0, {{70, 30000}, {71, 30000}}, "DIM");
  EXPECT_TRUE(reads(inside.insert("X", 0, 0, {}, "TITLE")));
}

TEST_F(EdgeSelectionTest, NamesWhatItCannotRead) {
  for (const char* type : {"REGION", "BODY", "3DSOLID", "SURFACE", "PLANESURFACE", "NURBSURFACE",
                           "EXTRUDEDSURFACE", "REVOLVEDSURFACE", "SWEPTSURFACE", "LOFTEDSURFACE",
                           "MESH", "MLINE", "HELIX", "ACAD_PROXY_ENTITY", "3DFACE"})
    EXPECT_TRUE(refused(plate().entity(type, "CUT", {{70, 1}}), {type, "CUT", "explode"})) << type;
  DxfWriter mesh = plate();
  mesh.entity("POLYLINE", "CUT", {{70, 64}}).entity("SEQEND", "CUT", {});
  EXPECT_TRUE(refused(mesh, {"POLYLINE", "mesh"}));
}

TEST_F(EdgeSelectionTest, NamesExternalReferences) {
  DxfWriter dxf = plate();
  dxf.block("FRAME", 0, 0, 4, "sheets\\a3.dwg").endBlock().insert("frame", 0, 0);
  EXPECT_TRUE(refused(dxf, {"frame", "external reference", "sheets\\a3.dwg", "bind"}));
  DxfWriter overlay = plate();
  overlay.block("LAID", 0, 0, 8).endBlock().insert("LAID", 0, 0);
  EXPECT_TRUE(refused(overlay, {"LAID", "external reference"}));
  DxfWriter resolved = plate();
  resolved.block("OTHER", 0, 0, 64).circle(30, 20, 5).endBlock().insert("OTHER", 0, 0);
  EXPECT_EQ(load(resolved).loops.size(), 2u);
}

TEST_F(EdgeSelectionTest, LeavesSymbolsOut) {
  DxfWriter dxf = plate();
  dxf.block("SW_CENTERMARKSYMBOL_0").line(-1, 0, 1, 0, "0").line(0, -1, 0, 1, "0").endBlock();
  dxf.block("sw_note_3").line(0, 0, 9, 9, "0").endBlock();
  dxf.block("*D7").line(0, 0, 9, 9, "0").endBlock().block("*X3").line(0, 0, 9, 9, "0").endBlock();
  dxf.block("*U4").circle(0, 0, 3, "0").endBlock();
  dxf.insert("SW_CENTERMARKSYMBOL_0", 30, 20, {}, "CUT").insert("SW_CENTERMARKSYMBOL_0", 9, 9);
  dxf.insert("SW_NOTE_3", 0, 0).insert("*D7", 0, 0).insert("*X3", 0, 0).insert("*U4", 30, 20);
  const Drawing drawing = load(dxf);
  EXPECT_EQ(drawing.loops.size(), 2u);
  const Texts expected = {"block SW_CENTERMARKSYMBOL_0: centre mark", "block sw_note_3: annotation",
                          "hatches and fillings: 1 entity", "text and dimensions: 1 entity"};
  EXPECT_EQ(drawing.left_out, expected);
}

TEST_F(EdgeSelectionTest, SaysWhyNothingIsDrawn) {
  EXPECT_TRUE(refused(DxfWriter().rectangle(0, 0, 9, 9, "Print"),
                      {"no outline", "counts as print", "\"Print\"", "print_layers: []"}));
  EXPECT_TRUE(refused(DxfWriter().entity("LINE", "CUT", {{67, 1}, {11, 1}}),
                      {"paper space: 1 entity", "model space"}));
  EXPECT_TRUE(refused(DxfWriter().entity("HATCH", "CUT", {{10, 1}}),
                      {"hatches and fillings: 1 entity", "border of a hatch"}));
  DxfWriter words;
  EXPECT_TRUE(refused(text(words, "CUT"), {"no outline", "text and dimensions: 1 entity"}));
  EXPECT_TRUE(refused(DxfWriter().block("PART").rectangle(0, 0, 9, 9).endBlock(),
                      {"block PART, which no INSERT places: 1 entity", "insert its block"}));
  EXPECT_TRUE(refused(DxfWriter().block("*Paper_Space0").rectangle(0, 0, 9, 9).endBlock(),
                      {"paper space: 1 entity"}));
  EXPECT_TRUE(refused(DxfWriter().layer("C", -7).rectangle(0, 0, 9, 9, "C"),
                      {"layer C (off): 1 entity", "switch its layer on"}));
  EXPECT_TRUE(refused(DxfWriter().layer("C", 7, 1).rectangle(0, 0, 9, 9, "C"),
                      {"layer C (frozen): 1 entity", "thaw"}));
  EXPECT_TRUE(refused(DxfWriter().entity("LINE", "CUT", {{60, 1}, {11, 1}}), {"make it visible"}));
  EXPECT_TRUE(refused(DxfWriter(), {"no outline", "visible layer with a continuous line"}));
}

TEST_F(EdgeSelectionTest, KeepsLayersWhateverTheirLineTypes) {
  DxfWriter dxf;
  dxf.entity("CIRCLE", "CUT", {{6, "DASHDOT"}, {10, 30}, {20, 20}, {40, 5}});
  dxf.entity("LINE", "CUT", {{6, "CENTER"}, {10, 22}, {20, 20}, {11, 38}, {21, 20}});
  dxf.rectangle(0, 0, 60, 40);
  EXPECT_EQ(load(dxf).loops.size(), 1u);
  const Drawing kept = load(dxf, keeping({"CUT"}));
  EXPECT_EQ(kept.loops.size(), 2u);
  EXPECT_EQ(kept.left_out, Texts{"line type CENTER: 1 entity"});  // it ends freely
  EXPECT_TRUE(says(kept.warnings, {"DASHDOT: 1 entity", "keep_layers"}));
  DxfWriter outline;
  outline.layer("CUT", 7, 0, "HIDDEN").rectangle(0, 0, 60, 40);
  EXPECT_TRUE(refused(outline, {"line type HIDDEN", "keep_layers"}));
  EXPECT_EQ(load(outline, keeping({"CUT"})).loops.size(), 1u);
}

TEST_F(EdgeSelectionTest, TakesClosedEngravingsForPrints) {
  for (const char* layer :
       {"ETCH",      "etching",      "GRAVIR",    "GRAVÍR",       "gravír",     "GRAVUR",
        "MARKING",   "SCRIBE",       "SCRIBING",  "ENGRAVING",    "ENGRAVED",   "Laser Engrave",
        "V-ENGRAVE", "GRAVADO",      "GRAVAÇÃO",  "Grawerowanie", "INCISIONE",  "Inciso",
        "marquage",  "Beschriftung", "LASERMARK", "Laser-Mark",   "SILKSCREEN", "PRINTS"})
    EXPECT_EQ(count(load(plate().rectangle(20, 10, 40, 30, layer)), LoopKind::kPrint), 1) << layer;
  for (const char* layer : {"SKETCH", "CUT2", "REMARK"})
    EXPECT_EQ(count(load(plate().rectangle(20, 10, 40, 30, layer)), LoopKind::kHole), 1) << layer;
  DrawingParams none;
  none.print_layers.clear();
  EXPECT_EQ(count(load(plate().rectangle(20, 10, 40, 30, "ETCH"), none), LoopKind::kHole), 1);
}

TEST_F(EdgeSelectionTest, ToleratesNoiseInNormalsOnly) {
  const auto circle = [](double nx, double nz) {
    return plate().entity("CIRCLE", "CUT",
                          {{10, 30}, {20, 20}, {40, 8}, {210, nx}, {220, 0}, {230, nz}});
  };
  EXPECT_TRUE(boxNear(load(circle(1.1e-6, 0.9999999999994)).loops.at(1), 22, 12, 38, 28));
  EXPECT_TRUE(boxNear(load(circle(0, 0)).loops.at(1), 22, 12, 38, 28));      // means: none
  EXPECT_TRUE(boxNear(load(circle(0.015, 1)).loops.at(1), 22, 12, 38, 28));  // 0.002 mm shorter
  EXPECT_TRUE(refused(circle(0.1, 1), {"CIRCLE", "xy plane"}));
  EXPECT_TRUE(refused(circle(1, 0), {"CIRCLE", "xy plane"}));
  DxfWriter raised;  // its plane is seen from behind, and high: straight lines of sight
  raised.entity("CIRCLE", "CUT", {{10, -30}, {20, 20}, {30, 500}, {40, 8}, {230, -1}});
  EXPECT_TRUE(boxNear(load(raised.rectangle(0, 0, 60, 40)).loops.at(1), 22, 12, 38, 28));
}

TEST_F(EdgeSelectionTest, PlacesBlocksOfAllKinds) {
  DxfWriter dxf;  // turned, mirrored, stretched, in an array, nested
  dxf.block("SLOT", 1, 0).rectangle(1, 0, 5, 2, "0").endBlock();
  dxf.block("TWO").insert("SLOT", 0, 0).insert("SLOT", 0, 10, {{41, -1.0}}).endBlock();
  dxf.rectangle(-100, -100, 100, 100);
  dxf.insert("TWO", 50, 50, {{41, 2.0}, {42, 1.0}, {50, 90.0}});
  dxf.insert("SLOT", 0, 0, {{50, 90.0}, {70, 2}, {71, 3}, {44, 10}, {45, 20}});
  const Drawing drawing = load(dxf);
  ASSERT_EQ(drawing.loops.size(), 9u);
  EXPECT_TRUE(boxNear(drawing.loops[1], 48, 50, 50, 58));
  EXPECT_TRUE(boxNear(drawing.loops[2], 38, 42, 40, 50));
  EXPECT_TRUE(boxNear(drawing.loops[3], -2, 0, 0, 4));
  EXPECT_TRUE(boxNear(drawing.loops[4], -2, 10, 0, 14));
  EXPECT_TRUE(boxNear(drawing.loops[8], -42, 10, -40, 14));
  DxfWriter flat = plate();
  flat.block("B").circle(0, 0, 3, "0").endBlock().insert("B", 30, 20, {{41, 0.0}});
  EXPECT_TRUE(refused(flat, {"INSERT", "scales its block to nothing"}));
}

}  // namespace
}  // namespace planar_bin_picking
