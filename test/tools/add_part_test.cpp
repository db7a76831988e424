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
  EXPECT_TRUE(refused(kBracket + " " + dir_.path("parts") + " --name a/b", {"a/b", "slash"}));
  EXPECT_TRUE(refused(kBracket + " " + dir_.path("parts") + " --name .b", {"--name", "dot"}));
  for (const std::string wrong : {"nan", "-1", "1001"})
    EXPECT_TRUE(refused(kBracket + " " + dir_.path("parts") + " --thickness-mm " + wrong,
                        {"--thickness-mm is ", wrong, "1000"}));
  EXPECT_TRUE(refused(dir_.write("part.yaml", "drawing: bad.dxf\n") + " " + dir_.path("parts"),
                      {"part.yaml", "part file"}));
  EXPECT_TRUE(refused(dir_.path("gone.dxf") + " " + dir_.path("parts"),
                      {"gone.dxf: does not exist", "give a drawing (.dxf)"}));
  EXPECT_TRUE(refused(dir_.write("lever.dwg", "") + " " + dir_.path("parts"),
                      {"lever.dwg: is neither a drawing nor a STEP file"}));
  EXPECT_EQ(files(), 0u);
  dir_.write("parts/bracket.yaml", "mine");
  EXPECT_TRUE(refused(kBracket + " " + dir_.path("parts"), {"bracket.yaml", "--name"}));
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(read(in("bracket.yaml")), "mine");
}

class AddStep : public AddPart {
 protected:
  void SetUp() override {
    if (!READS_STEP) GTEST_SKIP() << "built without Open CASCADE";
  }
  static std::string data(const std::string& name) {
    return std::string(PACKAGE_DIR) + "/test/data/step/" + name;
  }
  int add(const std::string& path, const std::string& options = "") {
    return run(path + " " + dir_.path("parts") + " " + options);
  }
};

// 90 x 60 x 4 mm with rounded corners, a round hole and an elliptic one. The rim of its top is
// rounded, so that its bottom is the largest face: seen from below, x still runs to the right.
TEST_F(AddStep, ReadsTheLargestFlatFaceAndTheThickness) {
  ASSERT_EQ(add(data("plate.step")), 0) << error_;
  EXPECT_TRUE(error_.empty()) << error_;
  EXPECT_EQ(out_.find("part: plate\nunits: mm\nsize_mm: [90.000, 60.000]\n"), 0u) << out_;
  EXPECT_NE(out_.find("holes: 2\n"), std::string::npos) << out_;
  const PartFile part = loadPartFile(in("plate.yaml"));
  EXPECT_NEAR(part.thickness, 0.004, 1e-6);
  ASSERT_EQ(part.drawing.loops.size(), 3u);
  Eigen::AlignedBox2d outline, round, ellipse;
  for (const auto& p : part.drawing.loops[0].points) outline.extend(1e3 * p);
  const bool first = (part.drawing.loops[1].points[0] - Eigen::Vector2d(-0.015, 0)).norm() < 0.01;
  for (const auto& p : part.drawing.loops[first ? 1 : 2].points) round.extend(1e3 * p);
  for (const auto& p : part.drawing.loops[first ? 2 : 1].points) ellipse.extend(1e3 * p);
  const auto box = [](double x0, double y0, double x1, double y1) {
    return Eigen::AlignedBox2d(Eigen::Vector2d(x0, y0), Eigen::Vector2d(x1, y1));
  };
  EXPECT_TRUE(outline.isApprox(box(-30, -40, 60, 20), 1e-3)) << outline.min() << outline.max();
  EXPECT_TRUE(round.isApprox(box(-21, -6, -9, 6), 2e-3)) << round.min() << round.max();
  EXPECT_TRUE(ellipse.isApprox(box(20, -22, 50, -8), 1e-3)) << ellipse.min() << ellipse.max();
  // Rounded corners, of 8 mm.
  double nearest = 1.0;
  for (const auto& p : part.drawing.loops[0].points)
    nearest = std::min(nearest, (p - Eigen::Vector2d(0.06, 0.02)).norm());
  EXPECT_NEAR(nearest, 0.008 * (std::sqrt(2.0) - 1.0), 1e-4);
}

TEST_F(AddStep, HonoursItsUnit) {
  const std::string step = read(data("plate.step"));
  const std::string unit = "SI_UNIT(.MILLI.,.METRE.) );";
  const std::size_t at = step.find(unit);
  ASSERT_NE(at, std::string::npos);
  const auto with = [&](const std::string& other) {
    return std::string(step).replace(at, unit.size(), other);
  };
  ASSERT_EQ(add(dir_.write("cm.STP", with("SI_UNIT(.CENTI.,.METRE.) );"))), 0) << error_;
  EXPECT_NE(out_.find("size_mm: [900.000, 600.000]"), std::string::npos) << out_;
  EXPECT_NEAR(loadPartFile(in("cm.yaml")).thickness, 0.04, 1e-6);
  const std::size_t begin = step.rfind('#', at);  // "#923 = ( LENGTH_UNIT() NAMED_UNIT(*) "
  const std::string number = step.substr(begin, step.find(' ', begin) - begin);
  const std::string inch =
      number +
      " = ( CONVERSION_BASED_UNIT('INCH',#9001) LENGTH_UNIT() NAMED_UNIT(#9002) );\n"
      "#9001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9003);\n"
      "#9002 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
      "#9003 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );";
  ASSERT_EQ(
      add(dir_.write("inch.step", step.substr(0, begin) + inch + step.substr(at + unit.size()))), 0)
      << error_;
  EXPECT_NE(out_.find("size_mm: [2286.000, 1524.000]"), std::string::npos) << out_;
  EXPECT_TRUE(refused(data("plate.step") + " " + dir_.path("parts") + " --units mm", {"--units"}));
}

TEST_F(AddStep, TheThicknessThatIsGivenCounts) {
  ASSERT_EQ(add(data("plate.step"), "--name other --thickness-mm 3.8"), 0) << error_;
  EXPECT_NEAR(loadPartFile(in("other.yaml")).thickness, 0.0038, 1e-9);
}

TEST_F(AddStep, SaysWhatIsWrongAndLeavesTheFolderAsItWas) {
  const auto refuses = [&](const std::string& path, const std::vector<std::string>& words) {
    return refused(path + " " + dir_.path("parts"), words);
  };
  EXPECT_TRUE(refuses(data("bent.step"), {"bent.step", "no flat part", "DXF"}));
  EXPECT_TRUE(refuses(data("two.step"), {"two.step", "2 solids", "one part"}));
  EXPECT_TRUE(refuses(dir_.path("none.step"), {"none.step", "does not exist"}));
  EXPECT_TRUE(refuses(dir_.write("text.step", "no step"), {"text.step", "no STEP file"}));
  const std::string step = read(data("plate.step"));
  for (const double share : {0.1, 0.5, 0.9}) {
    const auto bytes = static_cast<std::size_t>(share * static_cast<double>(step.size()));
    EXPECT_TRUE(refuses(dir_.write("cut.step", step.substr(0, bytes)), {"cut.step"})) << share;
  }
  EXPECT_EQ(files(), 0u);
}

TEST_F(AddPart, SaysWhatItNeedsForStep) {
  if (READS_STEP) GTEST_SKIP() << "built with Open CASCADE";
  const std::string step = dir_.write("lever.step", "ISO-10303-21;");
  EXPECT_TRUE(refused(step + " " + dir_.path("parts"), {"lever.step", "libocct", "DXF"}));
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
