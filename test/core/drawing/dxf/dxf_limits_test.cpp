// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Files of a few kilobytes must not cost minutes or gigabytes: limits hold before they do.

#include "support/drawing_fixture.h"

#include <sys/stat.h>
#include <unistd.h>

#include <ctime>

namespace planar_bin_picking {
namespace {

class DxfLimits : public DrawingTest {
 protected:
  void SetUp() override { start_ = std::clock(); }
  /// Each takes some tenths of a second; what they guard against, a minute and more. A sanitizer's
  /// build needs some fifty times as long.
  void TearDown() override {
    EXPECT_LT(static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC, 60.0);
  }
  static DxfWriter plate() { return DxfWriter().rectangle(0, 0, 60, 40); }

  std::clock_t start_ = 0;
};

TEST_F(DxfLimits, OfPlacementsCountEmptyOnes) {
  DxfWriter nested = plate();
  nested.block("B0").endBlock();
  const DxfGroups array = {{70, 100}, {71, 100}, {44, 1}, {45, 1}};
  nested.block("B1").insert("B0", 0, 0, array).endBlock();
  nested.block("B2").insert("B1", 0, 0, array).endBlock();
  nested.block("B3").insert("B2", 0, 0, array).endBlock();
  EXPECT_TRUE(refused(nested.insert("B3", 0, 0), {"200000 entities"}));
  DxfWriter many = plate().block("B").endBlock();
  for (int i = 0; i < 20000; ++i) many.insert("B", 0, 0, array);
  EXPECT_TRUE(refused(many, {"200000 entities"}));
}

TEST_F(DxfLimits, OfPlacementsDoNotRefuseForSkippedLayers) {
  DxfWriter dxf = plate().block("B0").endBlock();
  const DxfGroups array = {{70, 30000}, {71, 30000}};
  dxf.block("B1").insert("B0", 0, 0, array).endBlock();
  EXPECT_EQ(load(dxf.insert("B1", 0, 0, array, "DIM")).loops.size(), 1u);
}

TEST_F(DxfLimits, OfChordsAndSizes) {
  DxfWriter huge = plate();
  for (int i = 0; i < 1000; ++i) huge.circle(0, 0, 1e9 + i);
  EXPECT_TRUE(refused(huge, {"CIRCLE", "1000 km"}));
  DxfWriter large = plate();
  for (int i = 0; i < 1000; ++i) large.circle(0, 0, 1e8 + i);
  EXPECT_TRUE(refused(large, {"CIRCLE", "too many points"}));
  EXPECT_TRUE(refused(plate().circle(0, 0, 1e8), {"mm large", "10 m"}));
  EXPECT_EQ(load(plate().circle(0, 0, 1e9, "DIM").circle(0, 0, 1e300, "DIM")).loops.size(), 1u);
}

TEST_F(DxfLimits, OfNumbers) {
  const auto ellipse = [](double major, double ratio, double start, double end) {
    return plate().entity(
        "ELLIPSE", "CUT",
        {{10, 30}, {20, 20}, {11, major}, {21, major}, {40, ratio}, {41, start}, {42, end}});
  };
  EXPECT_TRUE(refused(ellipse(1e200, 1e200, 0, 6), {"ELLIPSE", "1000 km"}));
  EXPECT_TRUE(refused(ellipse(5, 0.5, -1e300, 1e300), {"ELLIPSE", "angles"}));
  EXPECT_TRUE(refused(ellipse(0, 0.5, 0, 6), {"ELLIPSE", "axis without length"}));
  EXPECT_TRUE(refused(ellipse(5, 0, 0, 6), {"ELLIPSE", "axis without length"}));
  EXPECT_TRUE(refused(ellipse(5, -1, 0, 6), {"ELLIPSE", "axis without length"}));
  EXPECT_TRUE(refused(plate().circle(0, 0, 0), {"CIRCLE", "radius"}));
  EXPECT_TRUE(refused(plate().line(0, 0, 1e308, -1e308), {"LINE", "1000 km"}));
  DxfWriter scaled = plate().block("B").circle(1e200, 0, 1, "0").endBlock();
  EXPECT_TRUE(refused(scaled.insert("B", 0, 0, {{41, 1e200}}), {"CIRCLE", "1000 km"}));
}

TEST_F(DxfLimits, OfFitPoints) {
  const auto spline = [](double far, int flags) {
    return plate().entity(
        "SPLINE", "CUT",
        {{70, flags}, {71, 3}, {74, 3}, {11, 0}, {21, 0}, {11, far}, {21, 0}, {11, 100}, {21, 0}});
  };
  EXPECT_TRUE(refused(spline(1e160, 0), {"SPLINE"}));
  EXPECT_TRUE(refused(spline(1e308, 0), {"SPLINE"}));
  EXPECT_TRUE(refused(spline(1e-200, 0), {"SPLINE"}));
  EXPECT_TRUE(refused(spline(1e160, 1), {"SPLINE"}));
  EXPECT_TRUE(refused(plate().entity("SPLINE", "CUT", {{70, 1}, {11, 1}, {21, 1}}),
                      {"SPLINE", "too few fit points"}));
}

TEST_F(DxfLimits, OfEntities) {
  std::string text = "0\nSECTION\n2\nENTITIES\n";
  for (int i = 0; i < 400000; ++i) text += "0\nPOINT\n8\nA\n";
  EXPECT_TRUE(refused(text + "0\nENDSEC\n0\nEOF\n", {"300000 entities"}));
}

TEST_F(DxfLimits, OfLinesThatShareAnX) {
  std::vector<std::vector<double>> comb;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    comb.push_back({i % 2 == 0 ? 0.0 : 100.0, 0.3 * i});
    comb.push_back({i % 2 == 0 ? 100.0 : 0.0, 0.3 * i});
  }
  comb.push_back({-10, 0.3 * (n - 1)});
  comb.push_back({-10, 0});
  DxfWriter lines;
  for (std::size_t i = 0; i < comb.size(); ++i) {
    const auto &a = comb[i], &b = comb[(i + 1) % comb.size()];
    lines.line(a[0], a[1], b[0], b[1]);
  }
  EXPECT_EQ(load(lines).loops.at(0).points.size(), comb.size());
}

TEST_F(DxfLimits, OfCrowdedLines) {
  DxfWriter fan;
  for (int i = 0; i < 20000; ++i)
    fan.line(0, 0, 100 * std::cos(1e-4 * i), 100 * std::sin(1e-4 * i));
  EXPECT_TRUE(refused(fan, {"too many lines too close together"}));
}

TEST_F(DxfLimits, OfFiles) {
  const std::string pipe = dir_.path("part.dxf");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_TRUE(refuses([&] { loadDrawing(pipe); }, {"part.dxf", "no regular file"}));
  EXPECT_TRUE(refuses([&] { loadDrawing(dir_.path("")); }, {"no regular file"}));
  const std::string large = dir_.write("large.dxf", "0\n");
  ASSERT_EQ(truncate(large.c_str(), 65 << 20), 0);
  EXPECT_TRUE(refuses([&] { loadDrawing(large); }, {"large.dxf", "allowed are 67108864"}));
}

}  // namespace
}  // namespace planar_bin_picking
