// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// The program itself, as a user runs it, and the pictures that it and describe_part write.

#include "planar_bin_picking/part/part_file.h"
#include "support/tool_test.h"

#include <opencv2/imgcodecs.hpp>

#include <filesystem>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

const std::string kBracket = std::string(PACKAGE_DIR) + "/config/parts/bracket.dxf";

class AddPart : public ToolTest {
 protected:
  AddPart() : ToolTest(ADD_PART) { fs::create_directory(dir_.path("parts")); }
  std::string in(const std::string& name) const { return dir_.path("parts/" + name); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(dir_.path("parts")), {}));
  }
};

TEST_F(AddPart, WritesWhatALocatorReads) {
  ASSERT_EQ(run(kBracket + " " + dir_.path("parts") + " --name angle --thickness-mm 3"), 0)
      << error_;
  EXPECT_NE(out_.find("part: angle"), std::string::npos);
  EXPECT_EQ(files(), 3u);
  const PartFile part = loadPartFile(in("angle.yaml"));
  EXPECT_EQ(part.name, "angle");
  EXPECT_DOUBLE_EQ(part.thickness, 0.003);
  EXPECT_TRUE(part.pick_poses.empty());
  EXPECT_FALSE(cv::imread(in("angle.png")).empty());
}

// What is proposed in the comments is a part file that is right, too.
TEST_F(AddPart, ProposesPickPosesThatCanBeUsed) {
  ASSERT_EQ(run(kBracket + " " + dir_.path("parts") + " --name angle --thickness-mm 3"), 0);
  std::string text = read(in("angle.yaml")), used;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const bool is_proposal = line.rfind("# pick_poses", 0) == 0 || line.rfind("#   -", 0) == 0 ||
                             line.rfind("# tool", 0) == 0;
    used += (is_proposal ? line.substr(2) : line) + "\n";
  }
  dir_.write("parts/angle.yaml", used);
  const PartFile part = loadPartFile(in("angle.yaml"));
  ASSERT_EQ(part.pick_poses.size(), 2u);
  EXPECT_NEAR(part.pick_poses[0].T_part_pick.translation().x(), 0.06, 1e-4);
  EXPECT_NEAR(part.pick_poses[1].T_part_pick.translation().z(), -0.003, 1e-9);
  EXPECT_TRUE(part.tool.radius.has_value());
}

TEST_F(AddPart, TakesTheUnitThatItIsTold) {
  ASSERT_EQ(run(kBracket + " " + dir_.path("parts") + " --units cm"), 0) << error_;
  EXPECT_NE(out_.find("size_mm: [1200.000, 800.000]"), std::string::npos) << out_;
  EXPECT_NE(read(in("bracket.yaml")).find("position_mm: [600.0, 400.0, 0]"), std::string::npos)
      << read(in("bracket.yaml"));
}

TEST_F(AddPart, LeavesTheFolderAsItWasWhereItRefuses) {
  EXPECT_TRUE(refused(kBracket + " " + dir_.path("none"), {"no folder"}));
  dir_.write("bad.dxf", "no drawing");
  EXPECT_TRUE(refused(dir_.path("bad.dxf") + " " + dir_.path("parts"), {"bad.dxf"}));
  EXPECT_TRUE(refused(kBracket + " " + dir_.path("parts") + " --name a/b", {"slash"}));
  EXPECT_EQ(files(), 0u);
  dir_.write("parts/bracket.yaml", "mine");
  EXPECT_TRUE(refused(kBracket + " " + dir_.path("parts"), {"bracket.yaml", "--name"}));
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(read(in("bracket.yaml")), "mine");
}

class Pictures : public ToolTest {
 protected:
  Pictures() : ToolTest(DESCRIBE_PART) {}
};

TEST_F(Pictures, ShowBothFacesAndPickPoses) {
  const std::string yaml = std::string(PACKAGE_DIR) + "/test/data/parts/bracket.yaml";
  ASSERT_EQ(run("--pictures " + dir_.path("") + " " + yaml), 0) << error_;
  const cv::Mat picture = cv::imread(dir_.path("bracket.png"));
  ASSERT_FALSE(picture.empty());
  const auto count = [&](const cv::Rect& where, const cv::Scalar& color) {
    cv::Mat is_color;
    cv::inRange(picture(where), color, color, is_color);
    return cv::countNonZero(is_color);
  };
  const cv::Rect front(0, 0, picture.cols / 2, 640),
      back(picture.cols / 2, 0, picture.cols / 2, 640);
  for (const cv::Rect& face : {front, back}) {
    EXPECT_GT(count(face, {225, 220, 215}), 20000) << "the part's face";
    EXPECT_GT(count(face, {30, 30, 220}), 30) << "its pick poses";
    EXPECT_GT(count(face, {40, 40, 255}), 50) << "the x axis";
    EXPECT_GT(count(face, {40, 170, 40}), 50) << "the y axis";
  }
  EXPECT_TRUE(refused("--pictures " + dir_.path("none") + " " + yaml, {"none"}));
}

}  // namespace
}  // namespace planar_bin_picking
