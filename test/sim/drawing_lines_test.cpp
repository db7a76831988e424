// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/drawing_lines.h"

#include "sim/print_image.h"
#include "sim/simulated_cell.h"
#include "support/dxf_writer.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking::cell {
namespace {

constexpr double kChord = 1e-6;

class ReadLines : public testing::Test {
 protected:
  std::string write(const DxfWriter& dxf) { return dir_.write("part.dxf", dxf.text()); }
  DrawnLines read(const DxfWriter& dxf) { return readLines(write(dxf), kChord); }
  TempDir dir_;
};

testing::AssertionResult goes(const Polygon& line, const std::vector<Eigen::Vector2d>& corners_mm) {
  if (line.size() != corners_mm.size()) return testing::AssertionFailure() << line.size();
  for (std::size_t i = 0; i < line.size(); ++i)
    if ((1e3 * line[i] - corners_mm[i]).norm() > 1e-6)
      return testing::AssertionFailure() << i << ": " << 1e3 * line[i].transpose();
  return testing::AssertionSuccess();
}

TEST_F(ReadLines, PutsBlocksInTheirPlaces) {
  DxfWriter dxf;
  dxf.block("inner", 1, 0).line(1, 0, 3, 0, "0").endBlock();
  dxf.block("outer").insert("inner", 10, 0, {{41, 2.0}, {42, -1.0}}, "CUT").endBlock();
  dxf.insert("outer", 100, 50, {{50, 90.0}}, "CUT").line(0, 0, 1, 1);
  const DrawnLines lines = read(dxf);
  ASSERT_EQ(lines.edges.size(), 2u);
  // In `outer` from (10, 0) to (14, 0), then turned to the left and moved.
  EXPECT_TRUE(goes(lines.edges[0], {{100, 60}, {100, 64}}));
  EXPECT_TRUE(goes(lines.edges[1], {{0, 0}, {1, 1}}));
}

TEST_F(ReadLines, ABlocksLayerZeroIsThatOfItsInsert) {
  DxfWriter dxf;
  dxf.block("mark").line(0, 0, 1, 0, "0").line(0, 0, 2, 0, "CUT").endBlock();
  dxf.insert("mark", 0, 0, {}, "PRINT_TOP").insert("mark", 0, 0, {}, "DIM");
  const DrawnLines lines = read(dxf);
  ASSERT_EQ(lines.prints.size(), 1u);
  EXPECT_TRUE(goes(lines.prints[0], {{0, 0}, {1, 0}}));
  EXPECT_EQ(lines.edges.size(), 1u);
}

TEST_F(ReadLines, ARationalSplineIsACircle) {
  // Half a circle about (5, 0) of radius 20, from two quadratic pieces.
  const double w = std::sqrt(0.5);
  DxfGroups groups = {{70, 4}, {71, 2}, {72, 8}, {73, 5}};
  for (const double knot : {0, 0, 0, 1, 1, 2, 2, 2}) groups.emplace_back(40, knot);
  for (const double weight : {1.0, w, 1.0, w, 1.0}) groups.emplace_back(41, weight);
  const double points[][2] = {{25, 0}, {25, 20}, {5, 20}, {-15, 20}, {-15, 0}};
  for (const auto& p : points) groups.insert(groups.end(), {{10, p[0]}, {20, p[1]}});
  const DrawnLines lines = read(DxfWriter().entity("SPLINE", "CUT", groups));
  ASSERT_EQ(lines.edges.size(), 1u);
  const Polygon& half = lines.edges[0];
  EXPECT_NEAR(1e3 * half.front().x(), 25.0, 1e-9);
  EXPECT_NEAR(1e3 * half.back().x(), -15.0, 1e-9);
  for (std::size_t i = 0; i < half.size(); ++i) {
    EXPECT_NEAR((1e3 * half[i] - Eigen::Vector2d(5, 0)).norm(), 20.0, 1e-9);
    if (i == 0) continue;
    const double middle = (500.0 * (half[i - 1] + half[i]) - Eigen::Vector2d(5, 0)).norm();
    EXPECT_GT(middle, 20.0 - 1e3 * kChord);
  }
}

TEST_F(ReadLines, PassesOverWhatIsNoLine) {
  DxfWriter dxf;
  dxf.line(0, 0, 1, 0).line(0, 0, 1, 0, "CENTER").entity("TEXT", "CUT", {{1, "R5"}});
  dxf.line(0, 0, 4, 0, "ENGRAVE").line(0, 0, 4, 0, "SILK");
  const DrawnLines lines = read(dxf);
  EXPECT_EQ(lines.edges.size(), 1u);
  EXPECT_EQ(lines.prints.size(), 2u);
}

TEST_F(ReadLines, RefusesWhatItDoesNotRead) {
  const auto refused = [&](const DxfWriter& dxf, const std::vector<std::string>& words) {
    return refuses([&] { read(dxf); }, words);
  };
  EXPECT_TRUE(refused(DxfWriter().insert("none", 0, 0), {"none"}));
  EXPECT_TRUE(refused(DxfWriter().block("a").insert("a", 1, 0).endBlock().insert("a", 0, 0),
                      {"hold themselves"}));
  EXPECT_TRUE(refused(
      DxfWriter().block("a").line(0, 0, 1, 0).endBlock().insert("a", 0, 0, {{70, 3}}), {"rows"}));
  EXPECT_TRUE(refused(DxfWriter().entity("3DFACE", "CUT", {}), {"3DFACE"}));
  EXPECT_TRUE(refused(DxfWriter().entity("SPLINE", "CUT", {{71, 3}, {10, 1}, {20, 1}}), {"knots"}));
}

/// A plate of 60 x 40 mm that looks the same after half a turn, and upside down, but for its print.
class Printed : public ReadLines {
 protected:
  PartKind kind(bool is_printed) {
    DxfWriter dxf;
    dxf.rectangle(-30, -20, 30, 20);
    if (is_printed) dxf.polyline({{-20, 5}, {0, 5}, {0, 15}}, false, "PRINT");
    write(dxf);
    return loadPartKind(dir_.write("part.yaml",
                                   "drawing: part.dxf\nthickness_mm: 2\n"
                                   "pick_poses: [{name: a, position_mm: [10, 0, 0]}]\n"));
  }
};

TEST_F(Printed, InkLiesAboutTheLinesOnTheFrontAlone) {
  const PartKind part = kind(true);
  EXPECT_EQ(part.fine.prints.size(), 1u);
  const PrintImage print(part.fine, 0.001);
  const auto at = [&](float x_mm, float y_mm, float z_mm) {
    return print.at(1e-3f * Eigen::Vector3f(x_mm, y_mm, z_mm));
  };
  EXPECT_GT(at(-10, 5, 0), 0.99f);
  EXPECT_GT(at(0, 10, 0), 0.99f);
  EXPECT_NEAR(at(-10, 5.5f, 0), 0.5f, 0.2f);  // its border
  EXPECT_LT(at(-10, 6, 0), 0.01f);
  EXPECT_EQ(at(-10, 5, -2), 0.0f);
  EXPECT_EQ(at(25, -15, 0), 0.0f);
  EXPECT_TRUE(PrintImage(kind(false).fine).empty());
}

TEST_F(Printed, TellsPosesApartUnlessItLiesBelow) {
  const PartKind plain = kind(false), printed = kind(true);
  EXPECT_EQ(plain.symmetric_poses.size(), 4u);
  EXPECT_EQ(plain.back_symmetric_poses.size(), 4u);
  EXPECT_EQ(printed.symmetric_poses.size(), 1u);
  EXPECT_EQ(printed.back_symmetric_poses.size(), 2u);
  EXPECT_EQ(printed.grasps.size(), 4u);  // the cup does not mind
}

TEST_F(Printed, ShowsInThePicture) {
  CellConfig config;
  config.lens.width = 320, config.lens.height = 256;
  config.lens.fx = config.lens.fy = 1500.0, config.lens.cx = 159.5, config.lens.cy = 127.5;
  config.counts = {0};
  Eigen::Isometry3d T_base_camera = Eigen::Isometry3d::Identity();
  T_base_camera.translation().z() = 0.5;
  T_base_camera.rotate(Eigen::AngleAxisd(3.14159265358979323846, Eigen::Vector3d::UnitX()));
  const auto greyAt = [&](bool is_printed, double x_mm, double y_mm) {
    SimulatedCell cell(config, {kind(is_printed)});
    Eigen::Isometry3d T_base_part = Eigen::Isometry3d::Identity();
    T_base_part.translation().z() = 0.002;
    cell.heap().put(0, T_base_part);
    cell.update();
    const cv::Mat picture = cell.takePicture(T_base_camera, 0.006);
    const double per_mm = 1.5 / 0.498;  // the front face is 0.498 m away
    const int u = static_cast<int>(std::lround(159.5 + per_mm * x_mm));
    const int v = static_cast<int>(std::lround(127.5 - per_mm * y_mm));
    return static_cast<double>(picture.at<unsigned char>(v, u));
  };
  EXPECT_LT(greyAt(true, -10, 5), 0.6 * greyAt(false, -10, 5));
  EXPECT_NEAR(greyAt(true, 20, -10), greyAt(false, 20, -10), 5.0);
}

}  // namespace
}  // namespace planar_bin_picking::cell
