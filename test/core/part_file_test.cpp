// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part_file.h"

#include "support/dxf_writer.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;

class PartFileTest : public testing::Test {
 protected:
  PartFileTest() {
    DxfWriter dxf;
    dxf.rectangle(0, 0, 40, 20).circle(10, 10, 3, "HOLES").line(20, 5, 30, 5, "PRINT");
    dxf.line(0, 0, 3, 3, "TITLE");
    dir_.write("plate.dxf", dxf.text());
  }

  PartFile load(const std::string& yaml) { return loadPartFile(dir_.write("plate.yaml", yaml)); }
  testing::AssertionResult refused(const std::string& yaml, std::vector<std::string> words) {
    words.push_back("plate.yaml");
    return refuses([&] { load(yaml); }, words);
  }

  TempDir dir_;
};

TEST_F(PartFileTest, ADrawingAloneIsEnough) {
  const PartFile part = loadPartFile(dir_.path("plate.dxf"));
  EXPECT_EQ(part.name, "plate");
  EXPECT_EQ(part.thickness, 0.0);
  EXPECT_TRUE(part.pick_poses.empty());
  EXPECT_EQ(part.drawing.loops.size(), 3u);
}

TEST_F(PartFileTest, ADrawingIsReadWithTheYamlBesideIt) {
  dir_.write("plate.yaml", "drawing: plate.dxf\nthickness_mm: 2.5\n");
  EXPECT_DOUBLE_EQ(loadPartFile(dir_.path("plate.dxf")).thickness, 2.5e-3);
  EXPECT_DOUBLE_EQ(loadPartFile(dir_.path("plate.yaml")).thickness, 2.5e-3);
}

TEST_F(PartFileTest, TheNameIsThatOfTheFile) {
  const std::string path = dir_.write("left_plate.yaml", "drawing: plate.dxf\n");
  EXPECT_EQ(loadPartFile(path).name, "left_plate");
}

TEST_F(PartFileTest, ReadsLayerLists) {
  EXPECT_EQ(load("drawing: plate.dxf\nskip_layers: [TITLE, HOLES]\n").drawing.loops.size(), 2u);
  EXPECT_EQ(load("drawing: plate.dxf\nkeep_layers: [CUT, PRINT]\n").drawing.loops.size(), 2u);
  EXPECT_EQ(load("drawing: plate.dxf\nprint_layers: [HOLES]\nskip_layers: [TITLE, PRINT]\n")
                .drawing.loops.back()
                .kind,
            LoopKind::kPrint);
  // The list that the file gives stands in place of the default one: TITLE becomes an open contour.
  EXPECT_TRUE(
      refuses([&] { load("drawing: plate.dxf\nskip_layers: []\n"); }, {"open contour", "TITLE"}));
  // Whoever names layers to keep means them, even where the default list would skip them.
  EXPECT_TRUE(refuses([&] { load("drawing: plate.dxf\nkeep_layers: [CUT, TITLE]\n"); },
                      {"open contour", "TITLE"}));
}

TEST_F(PartFileTest, ReadsPickPoses) {
  const PartFile part = load(
      "drawing: plate.dxf\n"
      "pick_poses:\n"
      "  - {name: middle, position_mm: [20, 10, 0]}\n"
      "  - {name: edge, position_mm: [1, -2, 3.5], rpy_deg: [180, 0, 90], face: back}\n");
  ASSERT_EQ(part.pick_poses.size(), 2u);
  EXPECT_EQ(part.pick_poses[0].name, "middle");
  EXPECT_EQ(part.pick_poses[0].face, FaceFilter::kAny);
  Eigen::Isometry3d expected = Eigen::Isometry3d::Identity();
  expected.translation() << 0.020, 0.010, 0.0;
  EXPECT_TRUE(isometryNear(part.pick_poses[0].T_part_pick, expected, 1e-12, 1e-9));
  EXPECT_EQ(part.pick_poses[1].face, FaceFilter::kBack);
  // Roll first, then yaw: the tool's x along the part's y, its z into the part.
  expected.translation() << 0.001, -0.002, 0.0035;
  expected.linear().col(0) = Eigen::Vector3d::UnitY();
  expected.linear().col(1) = Eigen::Vector3d::UnitX();
  expected.linear().col(2) = -Eigen::Vector3d::UnitZ();
  EXPECT_TRUE(isometryNear(part.pick_poses[1].T_part_pick, expected, 1e-12, 1e-7));
}

TEST_F(PartFileTest, ReadsTheTool) {
  EXPECT_FALSE(load("drawing: plate.dxf\n").tool.radius);
  EXPECT_FALSE(load("drawing: plate.dxf\n").tool.height);
  const PartFile part = load("drawing: plate.dxf\ntool_radius_mm: 12.5\ntool_height_mm: 0\n");
  EXPECT_DOUBLE_EQ(part.tool.radius.value(), 0.0125);
  EXPECT_EQ(part.tool.height.value(), 0.0);
  EXPECT_TRUE(refused("drawing: plate.dxf\ntool_radius_mm: -1\n", {"tool_radius_mm", "-1", "0"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\ntool_height_mm: high\n", {"tool_height_mm", "high"}));
}

TEST_F(PartFileTest, PickPosesAreSymmetricUnlessToldOtherwise) {
  const PartFile part = load(
      "drawing: plate.dxf\npick_poses:\n  - {name: a, position_mm: [0, 0, 0]}\n"
      "  - {name: b, position_mm: [1, 0, 0], symmetric: false}\n");
  EXPECT_TRUE(part.pick_poses.at(0).symmetric);
  EXPECT_FALSE(part.pick_poses.at(1).symmetric);
}

TEST_F(PartFileTest, RollPitchYawAreAboutFixedAxes) {
  const PartFile part = load(
      "drawing: plate.dxf\npick_poses: [{name: a, position_mm: [0, 0, 0], rpy_deg: [10, 20, "
      "30]}]\n");
  const Eigen::Matrix3d expected = (Eigen::AngleAxisd(30 * kPi / 180, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(20 * kPi / 180, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(10 * kPi / 180, Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  EXPECT_TRUE(part.pick_poses.at(0).T_part_pick.linear().isApprox(expected, 1e-12));
}

TEST_F(PartFileTest, NamesTheKeyOfWhatIsWrong) {
  EXPECT_TRUE(refused("thickness_mm: 3\n", {"drawing", "missing"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\nthicknes_mm: 3\n",
                      {"unknown key", "thicknes_mm", "thickness_mm"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\nthickness_mm: thin\n", {"thickness_mm", "thin"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\nthickness_mm: -1\n", {"thickness_mm", "-1"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\nthickness_mm: .nan\n", {"thickness_mm", "nan"}));
  EXPECT_TRUE(
      refused("drawing: plate.dxf\nthickness_mm: 2\nthickness_mm: 3\n", {"thickness_mm", "twice"}));
  EXPECT_TRUE(
      refused("drawing: plate.dxf\nskip_layers: TITLE\n", {"skip_layers", "TITLE", "a list"}));
  EXPECT_TRUE(refused("drawing: other.dxf\n", {"other.dxf", "does not exist"}));
  EXPECT_TRUE(refused("drawing: [plate.dxf]\n", {"drawing"}));
  EXPECT_TRUE(refused("- drawing\n", {"key"}));
}

TEST_F(PartFileTest, NamesWhatIsWrongInPickPoses) {
  const auto wrong = [this](const std::string& poses, const std::vector<std::string>& words) {
    return refused("drawing: plate.dxf\npick_poses: " + poses + "\n", words);
  };
  EXPECT_TRUE(wrong("3", {"pick_poses", "a list"}));
  EXPECT_TRUE(wrong("[middle]", {"pick_poses[0]", "middle"}));
  EXPECT_TRUE(wrong("[{position_mm: [0, 0, 0]}]", {"pick_poses[0]", "name", "missing"}));
  EXPECT_TRUE(wrong("[{name: a}]", {"pick_poses[0]", "position_mm", "missing"}));
  EXPECT_TRUE(wrong("[{name: a, position_mm: [0, 0]}]", {"position_mm", "[0, 0]", "three"}));
  EXPECT_TRUE(wrong("[{name: a, position_mm: [0, 0, .inf]}]", {"position_mm", "finite"}));
  EXPECT_TRUE(wrong("[{name: a, position_mm: [0, 0, 0], rpy_deg: [1, x, 3]}]", {"rpy_deg", "x"}));
  EXPECT_TRUE(wrong("[{name: a, position_mm: [0, 0, 0], face: top}]", {"face", "top", "front"}));
  EXPECT_TRUE(wrong("[{name: a, position_mm: [0, 0, 0], symmetric: 4}]", {"symmetric", "true"}));
  EXPECT_TRUE(wrong("[{name: a@2, position_mm: [0, 0, 0]}]", {"name", "a@2"}));
  EXPECT_TRUE(wrong("[{name: a, position_mm: [0, 0, 0], rpy: [0, 0, 0]}]",
                    {"unknown key", "\"rpy\"", "rpy_deg"}));
  EXPECT_TRUE(wrong("[{name: a, position_mm: [0, 0, 0]}, {name: a, position_mm: [0, 0, 0]}]",
                    {"pick_poses[1]", "\"a\"", "twice"}));
}

TEST_F(PartFileTest, RefusesOtherFiles) {
  EXPECT_TRUE(
      refuses([&] { loadPartFile(dir_.path("none.yaml")); }, {"none.yaml", "does not exist"}));
  EXPECT_TRUE(refuses([&] { loadPartFile(dir_.write("part.step", "ISO-10303-21;")); },
                      {"part.step", ".dxf"}));
  EXPECT_TRUE(refuses([&] { loadPartFile(dir_.write("bad.dxf", "")); }, {"bad.dxf", "empty"}));
}

}  // namespace
}  // namespace planar_bin_picking
