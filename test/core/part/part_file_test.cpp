// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/part_file.h"

#include "support/dxf_writer.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

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
      "  - {name: middle, position_mm: [20, 10, 0], face: back}\n"
      "  - {name: edge, position_mm: [1, -2, 3.5], rpy_deg: [180, 0, 90], face: front}\n");
  ASSERT_EQ(part.pick_poses.size(), 2u);
  EXPECT_EQ(part.pick_poses[0].name, "middle");
  EXPECT_EQ(part.pick_poses[0].face, FaceFilter::kBack);
  Eigen::Isometry3d expected = Eigen::Isometry3d::Identity();
  expected.translation() << 0.020, 0.010, 0.0;
  EXPECT_TRUE(isometryNear(part.pick_poses[0].T_part_pick, expected, 1e-12, 1e-9));
  EXPECT_EQ(part.pick_poses[1].face, FaceFilter::kFront);
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
  const PartFile hints =
      load("drawing: plate.dxf\napproach_mm: 80\nretreat_mm: 0\npart_number: 7\ntool_number: 3\n");
  EXPECT_EQ(hints.robot.approach, 0.08);
  EXPECT_EQ(hints.robot.retreat, 0.0);
  EXPECT_EQ(hints.robot.part_number, 7);
  EXPECT_EQ(hints.robot.tool_number, 3);
  EXPECT_FALSE(load("drawing: plate.dxf\n").robot.approach.has_value());
  EXPECT_TRUE(refused("drawing: plate.dxf\npart_number: 1.5\n", {"part_number", "1.5"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\ntool_number: -1\n", {"tool_number", "-1"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\nretreat_mm: far\n", {"retreat_mm", "far"}));
  const PartFile part = load("drawing: plate.dxf\ntool_radius_mm: 12.5\ntool_height_mm: 0\n");
  EXPECT_DOUBLE_EQ(part.tool.radius.value(), 0.0125);
  EXPECT_EQ(part.tool.height.value(), 0.0);
  EXPECT_TRUE(refused("drawing: plate.dxf\ntool_radius_mm: -1\n", {"tool_radius_mm", "-1", "0"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\ntool_height_mm: high\n", {"tool_height_mm", "high"}));
}

TEST_F(PartFileTest, PickPosesAreSymmetricUnlessToldOtherwise) {
  const PartFile part = load(
      "drawing: plate.dxf\npick_poses:\n  - {name: a, position_mm: [0, 0, 0], face: back}\n"
      "  - {name: b, position_mm: [1, 0, 0], face: back, symmetric: false}\n");
  EXPECT_TRUE(part.pick_poses.at(0).symmetric);
  EXPECT_FALSE(part.pick_poses.at(1).symmetric);
}

TEST_F(PartFileTest, RollPitchYawAreAboutFixedAxes) {
  const PartFile part = load(
      "drawing: plate.dxf\npick_poses: [{name: a, face: back, position_mm: [0, 0, 0], "
      "rpy_deg: [10, 20, 30]}]\n");
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
  EXPECT_TRUE(refused("- drawing\n", {"no part file", "list"}));
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
  for (const char* name : {"", "a/b", "a b", "a\\tb", "a\\nb", "\\x7f"}) {
    EXPECT_TRUE(wrong(std::string("[{name: \"") + name + "\", position_mm: [0, 0, 0]}]",
                      {"pick_poses[0]", "name", "a word"}))
        << name;
  }
  EXPECT_TRUE(wrong("[{name: a, position_mm: [0, 0, 0], rpy: [0, 0, 0]}]",
                    {"unknown key", "\"rpy\"", "rpy_deg"}));
  EXPECT_TRUE(
      wrong("[{name: a, face: back, position_mm: [0, 0, 0]}, {name: a, face: back, "
            "position_mm: [0, 0, 0]}]",
            {"pick_poses[1]", "\"a\"", "twice"}));
}

TEST_F(PartFileTest, ReadsHowToReadTheDrawing) {
  EXPECT_TRUE(refused("drawing: plate.dxf\nunits: feet\n", {"units", "feet", "mm, cm, m or inch"}));
  EXPECT_TRUE(refused("drawing: plate.dxf\nunits: [mm]\n", {"units", "mm, cm, m or inch"}));
  // A gap of 0.1 mm is none where the file says so.
  dir_.write("gap.dxf", DxfWriter()
                            .line(0, 0, 40, 0)
                            .line(40, 0, 40, 20)
                            .line(40, 20, 0, 20)
                            .line(0, 20, 0, 0.1)
                            .text());
  EXPECT_TRUE(refuses([&] { load("drawing: gap.dxf\n"); }, {"open contour"}));
  EXPECT_EQ(load("drawing: gap.dxf\njoin_tolerance_mm: 0.2\n").drawing.loops.size(), 1u);
  for (const char* value : {"0", "0.0009", "5.1", "-1", ".nan", "wide"}) {
    EXPECT_TRUE(refused(std::string("drawing: plate.dxf\njoin_tolerance_mm: ") + value + "\n",
                        {"join_tolerance_mm", "between 0.001 and 5"}))
        << value;
  }
  EXPECT_NO_THROW(load("drawing: plate.dxf\njoin_tolerance_mm: 0.001\n"));
}

TEST_F(PartFileTest, SeesAPartFileOfAnyEnding) {
  const std::string yaml = "drawing: plate.dxf\nthickness_mm: 2.5\n";
  for (const char* name : {"plate.yml", "plate.YAML"}) {
    dir_.write(name, yaml);
    EXPECT_DOUBLE_EQ(loadPartFile(dir_.path("plate.dxf")).thickness, 2.5e-3) << name;
    EXPECT_DOUBLE_EQ(loadPartFile(dir_.path(name)).thickness, 2.5e-3) << name;
    std::filesystem::remove(dir_.path(name));
  }
  dir_.write("plate.yml", yaml);
  dir_.write("plate.yaml", yaml);
  for (const char* name : {"plate.dxf", "plate.yaml", "plate.yml"}) {
    EXPECT_TRUE(refuses([&] { loadPartFile(dir_.path(name)); },
                        {"two part files", "plate.yaml", "plate.yml", "keep one"}));
  }
}

TEST_F(PartFileTest, IsReadInTheFolderThatOneStandsIn) {
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(dir_.path(""));
  dir_.write("plate.yml", "drawing: plate.dxf\nthickness_mm: 1\n");
  const auto thickness = [](const char* path) { return loadPartFile(path).thickness; };
  EXPECT_DOUBLE_EQ(thickness("plate.dxf"), 1e-3);
  EXPECT_DOUBLE_EQ(thickness("./plate.yml"), 1e-3);
  std::filesystem::current_path(before);
}

TEST_F(PartFileTest, SaysWhatIsNoPartFile) {
  const auto isNone = [&](const std::string& yaml, const std::string& word) {
    try {
      load(yaml);
    } catch (const NoPartFile& e) {
      const std::string text = e.what();
      return text.find("no part file") != std::string::npos &&
             text.find("plate.yaml") != std::string::npos && text.find(word) != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(isNone("seconds: 0.4\nthreshold: 0.8\ndetections: []\n", "result of locate_image"));
  EXPECT_TRUE(isNone("image_width: 9\ncamera_matrix: {rows: 3}\n", "camera's calibration"));
  EXPECT_TRUE(isNone("header: {}\nK: [1]\n", "CameraInfo"));
  EXPECT_TRUE(isNone("parent_frame: flange\nchild_frame: camera\n", "hand-eye"));
  EXPECT_TRUE(isNone("verdict: GOOD\n", "report of a calibration"));
  EXPECT_TRUE(isNone("score: {threshold: 0.7}\n", "none of a part file's keys"));
  EXPECT_TRUE(isNone("- {image: a.png}\n", "list"));
  EXPECT_TRUE(isNone("", "key: value"));
  // One key of a part file, and it is one with a mistake in it.
  EXPECT_TRUE(refused("detections: []\nthickness_mm: 3\n", {"unknown key", "detections"}));
}

TEST_F(PartFileTest, RefusesWhatIsNoRegularFile) {
  ASSERT_EQ(mkfifo(dir_.path("pipe.yaml").c_str(), 0600), 0);
  ASSERT_EQ(mkfifo(dir_.path("pipe2.dxf").c_str(), 0600), 0);
  std::filesystem::create_directory(dir_.path("folder.yaml"));
  std::filesystem::create_directory(dir_.path("folder2.dxf"));
  for (const char* name : {"pipe.yaml", "pipe2.dxf", "folder.yaml", "folder2.dxf"}) {
    EXPECT_TRUE(refuses([&] { loadPartFile(dir_.path(name)); }, {name, "no regular file"}));
    EXPECT_FALSE(drawingNamedBy(dir_.path(name)));
  }
  EXPECT_TRUE(refused("drawing: pipe2.dxf\n", {"pipe2.dxf", "no regular file"}));
  EXPECT_TRUE(refused("drawing: .\n", {"no regular file"}));
  // One beside a drawing might be meant to say something about it.
  dir_.write("pipe.dxf", DxfWriter().rectangle(0, 0, 9, 9).text());
  EXPECT_TRUE(refuses([&] { loadPartFile(dir_.path("pipe.dxf")); }, {"pipe.yaml", "no regular"}));
  EXPECT_TRUE(refuses([] { loadPartFile(""); }, {"empty"}));
}

TEST_F(PartFileTest, ReadsNothingOutsideOfItsFolder) {
  namespace fs = std::filesystem;
  const TempDir elsewhere;
  const std::string plate = DxfWriter().rectangle(0, 0, 9, 9).text();
  const std::string secret = elsewhere.write("secret.dxf", "the first line of it");
  elsewhere.write("part.dxf", plate);
  elsewhere.write("part.yaml", "drawing: part.dxf\n");
  const auto outside = [&](const std::string& yaml) {
    try {
      load(yaml);
    } catch (const std::runtime_error& e) {
      const std::string text = e.what();
      return text.find("leads out of the folder") != std::string::npos &&
             text.find("the first line") == std::string::npos;
    }
    return false;
  };
  const std::string up = "../" + fs::path(secret).parent_path().filename().string();
  EXPECT_TRUE(outside("drawing: " + up + "/part.dxf\n"));
  EXPECT_TRUE(outside("drawing: " + up + "/none.dxf\n"));
  EXPECT_TRUE(outside("drawing: " + secret + "\n"));
  fs::create_symlink(secret, dir_.path("link.dxf"));
  EXPECT_TRUE(outside("drawing: link.dxf\n"));
  fs::create_directory_symlink(fs::path(secret).parent_path(), dir_.path("away"));
  EXPECT_TRUE(outside("drawing: away/part.dxf\n"));
  // The part file itself, or the one beside a drawing, or the drawing alone.
  fs::create_symlink(elsewhere.path("part.yaml"), dir_.path("part.yaml"));
  dir_.write("part.dxf", plate);
  for (const char* name : {"part.yaml", "part.dxf", "link.dxf"}) {
    EXPECT_TRUE(
        refuses([&] { loadPartFile(dir_.path(name)); },
                {std::string(name) == "link.dxf" ? name : "part.yaml", "leads out of the folder"}));
  }
  // Within the folder, and by way of a link to the whole folder, all is well.
  fs::create_symlink(dir_.path("plate.dxf"), dir_.path("same.dxf"));
  EXPECT_EQ(load("drawing: same.dxf\n").drawing.loops.size(), 3u);
  fs::create_directory(dir_.path("drawings"));
  dir_.write("drawings/inner.dxf", plate);
  EXPECT_EQ(load("drawing: drawings/../drawings/inner.dxf\n").drawing.loops.size(), 1u);
  EXPECT_EQ(loadPartFile(dir_.path("away/part.dxf")).name, "part");
}

TEST_F(PartFileTest, TellsWhichDrawingAPartFileNames) {
  const auto named = [&](const std::string& yaml) {
    return drawingNamedBy(dir_.write("plate.yaml", yaml)).value_or("none");
  };
  EXPECT_EQ(named("drawing: ./plate.dxf\n"), dir_.path("plate.dxf"));
  EXPECT_EQ(named("drawing: other.dxf\npick_poses: 3\n"), dir_.path("other.dxf"));
  EXPECT_EQ(named("thickness_mm: 3\n"), "none");
  EXPECT_EQ(named("drawing: [a]\n"), "none");
  EXPECT_EQ(named("detections: []\n"), "none");
  EXPECT_EQ(named("drawing: &a [*a]\n"), "none");
}

TEST_F(PartFileTest, ListsHaveLimits) {
  const auto list = [](int count, const auto& entry) {
    std::string text = "[";
    for (int i = 0; i < count; ++i) text += entry(i) + std::string(", ");
    return text + "]\n";
  };
  const auto pose = [](int i) {
    return "{name: p" + std::to_string(i) + ", face: back, position_mm: [20, 10, 0]}";
  };
  EXPECT_EQ(load("drawing: plate.dxf\npick_poses: " + list(200, pose)).pick_poses.size(), 200u);
  EXPECT_TRUE(
      refused("drawing: plate.dxf\npick_poses: " + list(201, pose), {"pick_poses", "at most 200"}));
  for (const std::string key : {"keep_layers", "skip_layers", "print_layers"}) {
    const auto layer = [](int) { return "TITLE"; };
    EXPECT_TRUE(
        refused("drawing: plate.dxf\n" + key + ": " + list(1001, layer), {key, "at most 1000"}));
  }
  EXPECT_NO_THROW(
      load("drawing: plate.dxf\nskip_layers: " + list(1000, [](int) { return "TITLE"; })));
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
