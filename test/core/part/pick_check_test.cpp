// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part/pick_check.h"

#include "planar_bin_picking/part/part_model.h"
#include "support/dxf_writer.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

/// Through the part file, where a user meets it.
class PickCheck : public testing::Test {
 protected:
  PickCheck() {
    DxfWriter dxf;
    dxf.rectangle(0, 0, 40, 20).circle(10, 10, 3, "HOLES").line(20, 5, 30, 5, "PRINT");
    dir_.write("plate.dxf", dxf.text());
  }

  PartFile load(const std::string& yaml) { return loadPartFile(dir_.write("plate.yaml", yaml)); }
  testing::AssertionResult refused(const std::string& yaml, std::vector<std::string> words) {
    words.push_back("plate.yaml");
    return refuses([&] { load(yaml); }, words);
  }

  TempDir dir_;
};

TEST_F(PickCheck, APickPosePointsIntoThePart) {
  const auto pick = [](const std::string& rest) {
    return "drawing: plate.dxf\npick_poses: [{name: cup, position_mm: [20, 10, 0], " + rest +
           "}]\n";
  };
  // Upright, the tool would come out of the front; only the back is taken so.
  EXPECT_TRUE(refused(pick("face: front"), {"pick_poses[0]", "cup", "front is up",
                                            "[0.000, 0.000, 1.000]", "rpy_deg: [180, 0, 0]"}));
  EXPECT_TRUE(refused(pick("face: back, rpy_deg: [180, 0, 0]"),
                      {"cup", "back is up", "-1.000", "rpy_deg: [0, 0, 0]"}));
  // Whoever names the face means it.
  EXPECT_FALSE(refused(pick("face: front"), {"say face"}));
  EXPECT_FALSE(refused(pick("face: back, rpy_deg: [180, 0, 0]"), {"say face"}));
  EXPECT_EQ(load(pick("face: front, rpy_deg: [180, 0, 0]")).warnings.size(), 0u);
  EXPECT_EQ(load(pick("face: back")).warnings.size(), 0u);
  // One z cannot point into both faces.
  EXPECT_TRUE(refused(pick("symmetric: true"), {"cup", "front is up", "say face: back"}));
  EXPECT_TRUE(refused(pick("rpy_deg: [180, 0, 0]"), {"cup", "back is up", "say face: front"}));
  EXPECT_TRUE(refused(pick("face: any"), {"cup", "say face: back"}));
  // Slanted, but into it; along the face is not into it.
  EXPECT_NO_THROW(load(pick("face: front, rpy_deg: [180, 60, 0]")));
  EXPECT_NO_THROW(load(pick("face: front, rpy_deg: [91, 0, 0]")));
  EXPECT_TRUE(refused(pick("face: front, rpy_deg: [90, 0, 0]"), {"cup", "[180, 0, 0]"}));
  EXPECT_TRUE(refused(pick("face: front, rpy_deg: [89, 0, 0]"), {"cup"}));
  EXPECT_TRUE(refused(pick("rpy_deg: [90, 0, 0]"), {"cup", "face: front"}));
  EXPECT_NO_THROW(load(pick("face: back, rpy_deg: [89, 0, 0]")));
  EXPECT_TRUE(refused(pick("face: back, rpy_deg: [90, 0, 0]"), {"cup", "[0, 0, 0]"}));
}

/// Their copies are turns of the part, and so are right where the given ones are.
TEST_F(PickCheck, SoDoTheCopiesThatSymmetryMakes) {
  dir_.write("disk.dxf", DxfWriter().circle(10, 0, 20).circle(10, 0, 4).text());
  const PartModel part(loadPartFile(dir_.write(
      "disk.yaml",
      "drawing: disk.dxf\nthickness_mm: 2\npick_poses: [{name: cup, face: front, position_mm: [22, "
      "0, 0], rpy_deg: [170, 20, 30]}]\n")));
  ASSERT_EQ(part.pickPoses().size(), 24u);
  for (const PickPose& pose : part.pickPoses()) {
    const double into = pose.face == FaceFilter::kFront ? -1.0 : 1.0;
    EXPECT_GT(into * pose.T_part_pick.linear()(2, 2), 0.9) << pose.name;
  }
}

TEST_F(PickCheck, WarnsOfPickPosesThatMissThePart) {
  const auto warnings = [this](const std::string& position, const std::string& tool,
                               const std::string& turn = "rpy_deg: [180, 0, 0], face: front") {
    const auto part =
        load("drawing: plate.dxf\nthickness_mm: 3\n" + tool +
             "pick_poses: [{name: cup, position_mm: " + position + ", " + turn + "}]\n");
    std::string all;
    for (const std::string& warning : part.warnings) all += warning + "\n";
    return all;
  };
  const auto has = [](const std::string& text, const std::vector<std::string>& words) {
    for (const std::string& word : words) {
      if (text.find(word) == std::string::npos) return testing::AssertionFailure() << text;
    }
    return testing::AssertionSuccess();
  };
  EXPECT_EQ(warnings("[30, 10, 0]", ""), "");
  EXPECT_TRUE(has(warnings("[50, 10, 0]", ""), {"cup", "(50.0, 10.0) mm", "outside of the part"}));
  EXPECT_TRUE(has(warnings("[10, 9, 0]", ""), {"cup", "over a hole"}));
  // 40 x 20 with a hole of r 3 at (10, 10); a print is no edge.
  EXPECT_EQ(warnings("[25, 6, 0]", "tool_radius_mm: 5.9\n"), "");
  EXPECT_TRUE(has(warnings("[25, 6, 0]", "tool_radius_mm: 6.1\n"), {"6.0 mm", "edge", "6.1 mm"}));
  EXPECT_EQ(warnings("[17, 10, 0]", "tool_radius_mm: 3.9\n"), "");
  EXPECT_TRUE(has(warnings("[17, 10, 0]", "tool_radius_mm: 4.1\n"), {"4.0 mm", "hole", "4.1 mm"}));
  // Slanted, the tool's axis meets the face beside the point over it.
  EXPECT_EQ(warnings("[45, 10, 10]", "", "rpy_deg: [180, 45, 0], face: front"), "");
  EXPECT_TRUE(
      has(warnings("[35, 10, 10]", "", "rpy_deg: [180, -45, 0], face: front"), {"outside"}));
  // The back's face is 3 mm below; at z = 0 a cup would have to go through the part.
  EXPECT_EQ(warnings("[30, 10, -3]", "", "face: back"), "");
  EXPECT_EQ(warnings("[30, 10, -1.5]", "", "face: back"), "");
  EXPECT_TRUE(has(warnings("[30, 10, 0]", "", "face: back"), {"cup", "3.0 mm below", "z = -3.0"}));
  EXPECT_TRUE(has(warnings("[30, 10, -3]", ""), {"3.0 mm below the front"}));
}

}  // namespace
}  // namespace planar_bin_picking
