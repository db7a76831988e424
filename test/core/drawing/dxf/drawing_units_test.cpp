// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/drawing_units.h"

#include "support/drawing_fixture.h"

namespace planar_bin_picking {
namespace {

class Units : public DrawingTest {
 protected:
  Drawing plate(int insunits, double size, const std::string& told = "") {
    DrawingParams params;
    params.units = told;
    return load(DxfWriter(insunits).rectangle(0, 0, size, size), params);
  }
  static double width(const Drawing& drawing) { return boxMm(drawing.loops.at(0)).sizes().x(); }
};

TEST_F(Units, AreThoseOfTheFile) {
  const auto is = [this](int code, const std::string& name, double mm) {
    const Drawing drawing = plate(code, 100.0 / mm);
    return drawing.units == name && std::abs(width(drawing) - 100.0) < 1e-9;
  };
  EXPECT_TRUE(is(-1, "mm", 1.0));
  EXPECT_TRUE(is(0, "mm", 1.0));
  EXPECT_TRUE(is(1, "inch", 25.4));
  EXPECT_TRUE(is(2, "ft", 304.8));
  EXPECT_TRUE(is(4, "mm", 1.0));
  EXPECT_TRUE(is(5, "cm", 10.0));
  EXPECT_TRUE(is(6, "m", 1000.0));
  EXPECT_TRUE(is(8, "microinch", 25.4e-6));
  EXPECT_TRUE(is(9, "mil", 25.4e-3));
  EXPECT_TRUE(is(10, "yard", 914.4));
  EXPECT_TRUE(is(13, "micron", 1e-3));
  EXPECT_TRUE(is(14, "dm", 100.0));
  EXPECT_TRUE(is(22, "US survey inch", 100e3 / 3937));
}

TEST_F(Units, ThatAreToldComeFirst) {
  for (const int code : {-1, 4, 6, 99}) {  // also where the file's is no unit
    const Drawing drawing = plate(code, 2.0, "inch");
    EXPECT_EQ(drawing.units, "inch");
    EXPECT_NEAR(width(drawing), 50.8, 1e-9);
  }
  for (const auto& [told, name, mm] :
       std::vector<std::tuple<const char*, const char*, double>>{{"mm", "mm", 2},
                                                                 {"Millimeter", "mm", 2},
                                                                 {"cm", "cm", 20},
                                                                 {"m", "m", 2000},
                                                                 {"metres", "m", 2000},
                                                                 {"in", "inch", 50.8},
                                                                 {"inches", "inch", 50.8},
                                                                 {"ft", "ft", 609.6},
                                                                 {"feet", "ft", 609.6}}) {
    EXPECT_EQ(plate(1, 2.0, told).units, name);
    EXPECT_NEAR(width(plate(1, 2.0, told)), mm, 1e-9) << told;
  }
  EXPECT_THROW(plate(4, 30.0, "furlong"), std::invalid_argument);
  EXPECT_TRUE(refuses([&] { plate(4, 30.0, "furlong"); }, {"units", "furlong", "inch"}));
}

TEST_F(Units, ThatAreNotStatedAreDoubted) {
  EXPECT_TRUE(says(plate(-1, 4.72).warnings, {"no unit", "4.72 mm", "units: inch"}));
  EXPECT_TRUE(says(plate(0, 4.72).warnings, {"units: inch"}));
  EXPECT_TRUE(plate(4, 4.72).warnings.empty());
  EXPECT_TRUE(plate(-1, 4.72, "mm").warnings.empty());
  EXPECT_TRUE(plate(-1, 12.0).warnings.empty());
}

TEST_F(Units, MayBeEnglish) {
  const auto english = [this](int insunits, int measurement, const std::string& told = "") {
    DxfWriter dxf(insunits);
    dxf.variable("$MEASUREMENT", {{70, measurement}}).rectangle(0, 0, 60, 40);
    DrawingParams params;
    params.units = told;
    return load(dxf, params).warnings;
  };
  EXPECT_TRUE(says(english(-1, 0), {"$MEASUREMENT", "units: inch"}));
  EXPECT_TRUE(says(english(0, 0), {"$MEASUREMENT", "units: inch"}));
  EXPECT_TRUE(english(-1, 1).empty());
  EXPECT_TRUE(english(4, 0).empty());
  EXPECT_TRUE(english(-1, 0, "mm").empty());
}

TEST_F(Units, OfTolerancesAreMillimetres) {
  DrawingParams params;
  const auto check = [&](const std::string& word) {
    return refused(DxfWriter().rectangle(0, 0, 9, 9), params, {word, "between"});
  };
  params.join_tolerance_mm = 0.0;
  EXPECT_TRUE(check("join_tolerance_mm is 0"));
  params.join_tolerance_mm = 5.1;
  EXPECT_TRUE(check("join_tolerance_mm is 5.1"));
  params.join_tolerance_mm = std::nan("");
  EXPECT_TRUE(check("join_tolerance_mm"));
  params = DrawingParams();
  params.chord_tolerance_mm = 0.0;
  EXPECT_TRUE(check("chord_tolerance_mm"));
}

}  // namespace
}  // namespace planar_bin_picking
