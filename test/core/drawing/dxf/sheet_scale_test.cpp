// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/sheet_scale.h"

#include "support/drawing_fixture.h"

namespace planar_bin_picking {
namespace {

class SheetScale : public DrawingTest {
 protected:
  /// A plate of 60 x 40 with a horizontal dimension over its width.
  static DxfWriter plate(double header_factor, DxfGroups dimension = {}, int insunits = 4) {
    DxfWriter dxf(insunits);
    dxf.variable("$DIMLFAC", {{40, header_factor}}).rectangle(0, 0, 60, 40);
    dimension.insert(dimension.begin(), {{70, 32}, {13, 0}, {23, 0}, {14, 60}, {24, 0}});
    return dxf.entity("DIMENSION", "DIM", dimension);
  }
  double width(const DxfWriter& dxf) { return boxMm(load(dxf).loops.at(0)).sizes().x(); }
};

TEST_F(SheetScale, OfOneIsRead) {
  for (const DxfGroups& dimension :
       {DxfGroups{}, DxfGroups{{42, 60}}, DxfGroups{{1, "<>"}, {42, 60.2}}, DxfGroups{{1, "60"}},
        DxfGroups{{1, "60 H7 see note"}}, DxfGroups{{42, -1}}, DxfGroups{{42, 0}},
        DxfGroups{{1, " "}}, DxfGroups{{1, "M60"}}, DxfGroups{{42, "rubbish"}}}) {
    const Drawing drawing = load(plate(1, dimension));
    EXPECT_TRUE(drawing.warnings.empty());
    EXPECT_TRUE(boxNear(drawing.loops.at(0), 0, 0, 60, 40));
  }
}

TEST_F(SheetScale, OfTwoIsReadWhereDimensionsAndFactorAgree) {
  for (const DxfGroups& dimension :
       {DxfGroups{{42, 120}}, DxfGroups{{42, 120}, {1, "<>"}}, DxfGroups{{1, "120"}},
        DxfGroups{{1, "120 mm"}}, DxfGroups{{1, "120,0"}}, DxfGroups{}}) {
    const Drawing drawing = load(plate(2, dimension));
    EXPECT_TRUE(boxNear(drawing.loops.at(0), 0, 0, 120, 80));
    EXPECT_TRUE(says(drawing.warnings, {"says 120 where 60", "$DIMLFAC is 2"}));
  }
}

TEST_F(SheetScale, TakesTheFactorOfTheDimensionBeforeThatOfItsStyleBeforeThatOfTheHeader) {
  EXPECT_DOUBLE_EQ(width(plate(2, {{3, "Fine"}}).dimensionStyle("FINE", 3)), 180.0);
  EXPECT_DOUBLE_EQ(width(plate(2, {{3, "OTHER"}}).dimensionStyle("FINE", 3)), 120.0);
  const DxfGroups own = {{3, "FINE"}, {1001, "ACAD"}, {1000, "DSTYLE"}, {1002, "{"}, {1070, 40},
                         {1040, 7},   {1070, 144},    {1040, 4},        {1002, "}"}};
  EXPECT_DOUBLE_EQ(width(plate(2, own).dimensionStyle("FINE", 3)), 240.0);
  EXPECT_DOUBLE_EQ(width(plate(-2)), 60.0);  // of paper space
}

TEST_F(SheetScale, IsRefusedWhereOnlyTheDimensionSaysSo) {
  EXPECT_TRUE(refused(plate(1, {{42, 120}}), {"120", "60", "1:1"}));
  EXPECT_TRUE(refused(plate(1, {{1, "%%c90"}}), {"90", "60"}));
  EXPECT_TRUE(refused(plate(1, {{1, "R 30.5"}}), {"30.5", "60"}));
  EXPECT_TRUE(refused(plate(3, {{42, 120}}), {"120", "60"}));
}

TEST_F(SheetScale, OfAnotherUnitIsRefusedWithARemedyThatHelps) {
  const DxfGroups shown_in_mm = {{1, "1524"}};
  EXPECT_TRUE(refused(plate(1, shown_in_mm, 0), {"1524", "60", "units: inch"}));
  DrawingParams inch;
  inch.units = "inch";
  EXPECT_TRUE(boxNear(load(plate(1, shown_in_mm, 0), inch).loops.at(0), 0, 0, 1524, 1016));
  EXPECT_TRUE(refused(plate(1, {{1, "600"}}), {"units: cm"}));
  EXPECT_FALSE(refused(plate(1, {{1, "120"}}), {"units:"}));
}

TEST_F(SheetScale, IsDoubtedWhereDimensionsDisagree) {
  DxfWriter dxf = plate(1, {{42, 120}});
  dxf.entity("DIMENSION", "DIM", {{70, 1}, {13, 0}, {23, 0}, {14, 0}, {24, 40}, {42, 40}});
  const Drawing drawing = load(dxf);
  EXPECT_TRUE(boxNear(drawing.loops.at(0), 0, 0, 60, 40));
  EXPECT_TRUE(says(drawing.warnings, {"1 of 2 dimensions", "1:1"}));
}

TEST_F(SheetScale, IsNotMistakenForAnotherUnit) {
  EXPECT_DOUBLE_EQ(width(plate(1 / 25.4)), 60.0);             // mm, shown in inches
  EXPECT_DOUBLE_EQ(width(plate(25.4, {}, 1)), 1524.0);        // inches, shown in mm
  EXPECT_DOUBLE_EQ(width(plate(10, {{42, 600}}, 5)), 600.0);  // cm, shown in mm
  EXPECT_DOUBLE_EQ(width(plate(100)), 60.0);                  // a template for metres
  EXPECT_TRUE(load(plate(100)).warnings.empty());
  EXPECT_DOUBLE_EQ(width(plate(10, {{42, 600}})), 600.0);  // measured: a sheet at 1:10
}

TEST_F(SheetScale, IsSeenInAllLinearDimensions) {
  const auto refusedFor = [&](const DxfGroups& groups) {
    DxfWriter dxf;
    dxf.rectangle(0, 0, 60, 40).entity("DIMENSION", "DIM", groups);
    return refused(dxf, {"a dimension says 90 where 30 are drawn"});
  };
  EXPECT_TRUE(refusedFor({{70, 0}, {50, 90}, {13, 0}, {23, 0}, {14, 7}, {24, 30}, {42, 90}}));
  EXPECT_TRUE(refusedFor({{70, 33}, {13, 0}, {23, 0}, {14, 18}, {24, 24}, {42, 90}}));
  EXPECT_TRUE(refusedFor({{70, 163}, {10, 0}, {20, 0}, {15, 30}, {25, 0}, {42, 90}}));
  EXPECT_TRUE(refusedFor({{70, 4}, {10, 5}, {20, 0}, {15, 5}, {25, 30}, {42, 90}}));
}

TEST_F(SheetScale, DoesNotHearWhatIsNoLengthInModelSpace) {
  const DxfGroups wrong = {{13, 0}, {23, 0}, {14, 30}, {24, 0}, {42, 90}};
  for (const DxfGroups& more : {DxfGroups{{70, 2}}, DxfGroups{{70, 5}}, DxfGroups{{70, 6}},
                                DxfGroups{{70, 8}}, DxfGroups{{67, 1}}, DxfGroups{{60, 1}}}) {
    DxfGroups groups = wrong;
    groups.insert(groups.end(), more.begin(), more.end());
    DxfWriter dxf;
    EXPECT_TRUE(
        load(dxf.rectangle(0, 0, 60, 40).entity("DIMENSION", "DIM", groups)).warnings.empty());
  }
  DxfWriter dxf;  // of no length, and in a block
  dxf.rectangle(0, 0, 60, 40)
      .entity("DIMENSION", "DIM", {{13, 5}, {23, 0}, {14, 5}, {24, 0}, {42, 9}});
  dxf.block("B").entity("DIMENSION", "DIM", wrong).endBlock();
  EXPECT_TRUE(load(dxf).warnings.empty());
}

}  // namespace
}  // namespace planar_bin_picking
