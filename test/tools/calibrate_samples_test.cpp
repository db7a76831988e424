// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// Runs the program on pictures that are drawn here: its exit status and what it writes.

#include "planar_bin_picking/calibrate/calibration_file.h"
#include "planar_bin_picking/image/camera_file.h"
#include "sim/markers.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <yaml-cpp/yaml.h>
#include <opencv2/imgcodecs.hpp>

#include <cstdlib>
#include <regex>
#include <sstream>

namespace planar_bin_picking {
namespace {

/// Twelve pictures of the board, drawn once for all tests.
class CalibrateSamples : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = new TempDir;
    std::mt19937 random(5);
    cell_ = sim::makeCell(true, &random);
    cell_.camera = {1000, 800, 1400.0, 1398.0, 505.0, 396.0, {-0.1, 0.06, -5e-4, 4e-4, 0.0}};
    std::vector<Eigen::Vector2d> corners;
    for (int i = 0; i < 12;) {
      const auto T_camera_board = sim::randomView(cell_, 0.42, 35.0, 0.5, &random);
      if (!sim::seeCorners(cell_, T_camera_board, &random, &corners)) continue;
      samples_ += take(cell_, T_camera_board, "view" + std::to_string(i++) + ".png");
    }
    dir_->write("samples.yaml", samples_);
  }
  /// Draws a picture. @return  its line in a list of samples
  static std::string take(const sim::BoardCell& cell, const Eigen::Isometry3d& T_camera_board,
                          const std::string& name) {
    cv::imwrite(dir_->path(name),
                sim::takeBoardImage(cell, T_camera_board, 0.7, 2.0, static_cast<int>(name.size())));
    const Eigen::Isometry3d T = cell.flangeFor(T_camera_board);
    const Eigen::Quaterniond q(T.linear());
    std::ostringstream line;
    line.precision(12);
    line << "- {image: " << name << ", position: [" << T.translation().x() << ", "
         << T.translation().y() << ", " << T.translation().z() << "], orientation: [" << q.x()
         << ", " << q.y() << ", " << q.z() << ", " << q.w() << "]}\n";
    return line.str();
  }
  static void TearDownTestSuite() { delete dir_; }

  static std::string read(const std::string& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  int run(const std::string& board, const std::string& square, const std::string& more) {
    return runTool(std::string(CALIBRATE_SAMPLES) + " --board " + board + " --square " + square +
                   " --output " + out() + " " + more);
  }
  int runTool(const std::string& command) {
    const std::string error = dir_->path("error.txt"), said = dir_->path("said.txt");
    const int status = std::system((command + " >" + said + " 2>" + error).c_str());
    error_ = read(error);
    said_ = read(said);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  static std::string out() {
    return dir_->path(testing::UnitTest::GetInstance()->current_test_info()->name());
  }
  static std::string inHand(const std::string& samples = "samples.yaml") {
    return "--mode eye_in_hand --samples " + dir_->path(samples);
  }
  static bool exists(const std::string& name) { return std::ifstream(out() + "/" + name).good(); }

  /// Status 2 and one line with all of `words`.
  testing::AssertionResult refused(int status, const std::vector<std::string>& words) {
    bool good = status == 2 && std::count(error_.begin(), error_.end(), '\n') == 1;
    for (const std::string& word : words) good = good && error_.find(word) != std::string::npos;
    return (good ? testing::AssertionSuccess() : testing::AssertionFailure())
           << "status " << status << ", says: " << error_;
  }

  static TempDir* dir_;
  static sim::BoardCell cell_;
  static std::string samples_;
  std::string error_, said_;
};
TempDir* CalibrateSamples::dir_ = nullptr;
sim::BoardCell CalibrateSamples::cell_;
std::string CalibrateSamples::samples_;

TEST_F(CalibrateSamples, WritesWhatTheLocatorReads) {
  ASSERT_EQ(run("9x6", "0.02", inHand()), 0) << error_;
  const YAML::Node root = YAML::LoadFile(out() + "/calibration.yaml");
  EXPECT_EQ(root["verdict"].as<std::string>(), "GOOD") << root;
  EXPECT_EQ(root["reasons"].size(), 0u);
  EXPECT_EQ(root["views_used"].as<int>(), 12);
  EXPECT_EQ(root["transform"]["name"].as<std::string>(), "T_flange_camera");
  for (const char* key : {"rms_px", "pnp_floor_px", "expected_error_mm", "expected_error_deg"}) {
    EXPECT_GT(root[key].as<double>(), 0.0) << key;
  }
  EXPECT_LT(root["rms_px"].as<double>(), 0.1);
  EXPECT_EQ(root["camera_matrix"].size(), 9u);
  EXPECT_EQ(root["distortion"].size(), 5u);
  const HandEyeFile file = loadHandEye(out() + "/hand_eye.yaml");
  EXPECT_EQ(file.parent_frame, "flange");
  EXPECT_EQ(file.child_frame, "camera");
  // A picture of 0.8 Mpx: about three times as coarse as the 5 Mpx.
  EXPECT_TRUE(isometryNear(file.T_parent_child, cell_.T_mount_camera, 3e-4, 0.03 * sim::kDegree));
  const Camera camera = loadCamera(out() + "/camera_info.yaml");
  EXPECT_EQ(camera.model().width, 1000);
  EXPECT_NEAR(camera.model().fx / cell_.camera.fx, 1.0, 1e-3);
  const std::string report = read(out() + "/report.html");
  for (const char* word : {"GOOD", "Residuals", "Corners in the image", "view11.png", "</html>"}) {
    EXPECT_NE(report.find(word), std::string::npos) << word;
  }
}

TEST_F(CalibrateSamples, KeepsTheFormerFile) {
  ASSERT_EQ(run("9x6", "0.02", inHand()), 0);
  std::ofstream(out() + "/camera_info.yaml") << "former";
  ASSERT_EQ(run("9x6", "0.02", inHand()), 0);
  EXPECT_EQ(read(out() + "/camera_info.yaml.before"), "former");
  EXPECT_FALSE(exists("camera_info.yaml.new"));
}

TEST_F(CalibrateSamples, RefusesAWrongSquareAndSavesNothing) {
  EXPECT_EQ(run("9x6", "0.04", inHand()), 3);
  const std::string text = read(out() + "/calibration.yaml");
  EXPECT_NE(text.find("REFUSED"), std::string::npos);
  EXPECT_NE(text.find("square size wrong"), std::string::npos) << text;
  EXPECT_FALSE(exists("camera_info.yaml"));
  EXPECT_FALSE(exists("hand_eye.yaml"));
  EXPECT_TRUE(exists("report.html"));
}

TEST_F(CalibrateSamples, NamesAMiscountedBoard) {
  EXPECT_EQ(run("10x7", "0.02", inHand()), 3);
  const std::string text = read(out() + "/calibration.yaml");
  EXPECT_NE(text.find("miscounted"), std::string::npos) << text;
  EXPECT_NE(text.find("9x6"), std::string::npos) << text;
}

// A few of them do not spoil a good result; where most are, the board has to be moved.
TEST_F(CalibrateSamples, SaysWhichBoardsAreOutOfView) {
  const auto half = [](const std::string& name) {
    Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
    T_camera_board.linear() =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();  // cut off aslant
    T_camera_board.translation() =
        Eigen::Vector3d(0.15, 0.0, 0.42) - T_camera_board.linear() * cell_.centre();
    return take(cell_, T_camera_board, name);
  };
  dir_->write("one_out.yaml", samples_ + half("half.png"));
  EXPECT_EQ(run("9x6", "0.02", inHand("one_out.yaml")), 0) << said_;
  EXPECT_NE(said_.find("half.png: board partly out of view\n"), std::string::npos) << said_;
  dir_->write("out.yaml", half("half.png") + half("half1.png") + half("half12.png"));
  EXPECT_EQ(run("9x6", "0.02", inHand("out.yaml")), 3) << said_;
  EXPECT_NE(said_.find("  - board partly out of view: its edge leaves the picture"),
            std::string::npos)
      << said_;
  EXPECT_NE(said_.find("; 3 of 3 pictures show no usable board of 9x6"), std::string::npos)
      << said_;
  dir_->write("only.yaml", half("half.png"));
  EXPECT_EQ(run("9x6", "0.02", inHand("only.yaml")), 3) << said_;
  EXPECT_NE(said_.find("the only picture shows no usable board"), std::string::npos) << said_;
}

TEST_F(CalibrateSamples, SaysNothingOnStandardErrorAndWhereItWrote) {
  const std::string said = dir_->path("said.txt");
  const int status = std::system((std::string(CALIBRATE_SAMPLES) + " --board 9x6 --square 0.02 " +
                                  inHand() + " --output " + out() + " >" + said + " 2>&1")
                                     .c_str());
  ASSERT_EQ(WEXITSTATUS(status), 0);
  EXPECT_NE(read(said).find("written to " + out()), std::string::npos) << read(said);
  EXPECT_EQ(run("9x6", "0.04", inHand()), 3);
  EXPECT_EQ(error_, "");
}

// Each picture shows a part of the board; the board, the note and the trial lenses are in the file.
TEST_F(CalibrateSamples, TakesPartsOfABoardWithMarkers) {
  sim::BoardCell cell = cell_;
  sim::giveMarkers(&cell);
  std::mt19937 random(9);
  std::string samples;
  for (int i = 0; i < 14; ++i) {
    const auto T_camera_board = sim::randomView(cell, 0.3, 30.0, 0.7, &random);
    samples += take(cell, T_camera_board, "part" + std::to_string(i) + ".png");
  }
  dir_->write("parts.yaml", samples);
  dir_->write("board.yaml",
              "kind: charuco\ncorners: 9x6\nsquare: 0.02\nmarker: 0.015\n"
              "dictionary: DICT_4X4_100\n");
  const std::string tool = std::string(CALIBRATE_SAMPLES) + " --output " + out() + " ";
  ASSERT_EQ(runTool(tool + "--board-file " + dir_->path("board.yaml") + " " + inHand("parts.yaml")),
            0)
      << error_ << said_;
  const YAML::Node root = YAML::LoadFile(out() + "/calibration.yaml");
  EXPECT_EQ(root["board_kind"].as<std::string>(), "charuco");
  EXPECT_GE(root["views_used"].as<int>(), 12);
  int parts = 0;
  for (const YAML::Node& view : root["views"]) {
    if (view["used"].as<bool>()) parts += view["corners"].as<int>() < 54 ? 1 : 0;
  }
  EXPECT_GT(parts, 5);
  EXPECT_EQ(root["lens_trials"][0]["coefficients"].as<int>(), 5);
  EXPECT_GT(root["with_robot_mm"].as<double>(), root["expected_error_mm"].as<double>());
  const HandEyeFile file = loadHandEye(out() + "/hand_eye.yaml");
  EXPECT_TRUE(isometryNear(file.T_parent_child, cell.T_mount_camera, 6e-4, 0.06 * sim::kDegree));
  const std::string report = read(out() + "/report.html");
  for (const std::string& word :
       {std::string("Uncertainty map"), std::string("limit 1 mm (tolerance_mm)"),
        std::string("with the robot&#39;s noise"),
        std::string("by sigma and tolerance_mm), REFUSED above"), std::string("black: the board"),
        "src='" + dir_->path("part0.png")}) {
    EXPECT_NE(report.find(word), std::string::npos) << word;
  }
  // What is copied from the page is as fine as what is in the files.
  EXPECT_TRUE(std::regex_search(report, std::regex("fx</td><td class=n>1[34]\\d\\d\\.\\d{2,}")));
  EXPECT_TRUE(
      std::regex_search(report, std::regex("expected error 0\\.\\d{3} mm and 0\\.\\d{3} deg")));
  EXPECT_TRUE(refused(runTool(tool + inHand()), {"--board-file", "--square"}));
  EXPECT_TRUE(refused(runTool(tool + "--board 9x6 --square 0.02 --board-z up " + inHand()),
                      {"--board-z", "up", "number"}));
}

TEST_F(CalibrateSamples, ARobotOfFourAxesNeedsTheBoardsHeight) {
  Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
  T_camera_board.translation() = Eigen::Vector3d(0.0, 0.0, 0.42) - cell_.centre();
  const Eigen::Isometry3d start = cell_.flangeFor(T_camera_board);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::string samples;
  std::vector<Eigen::Vector2d> corners;
  for (int i = 0; i < 12;) {
    Eigen::Isometry3d T = start;
    T.linear() = Eigen::AngleAxisd(1.5 * any(random), Eigen::Vector3d::UnitZ()) * start.linear();
    T.translation() += 0.08 * Eigen::Vector3d(any(random), any(random), 0.5 * any(random));
    if (!sim::seeCorners(cell_, cell_.cameraBoard(T), &random, &corners)) continue;
    samples += take(cell_, cell_.cameraBoard(T), "upright" + std::to_string(i++) + ".png");
  }
  dir_->write("upright.yaml", samples);
  EXPECT_EQ(run("9x6", "0.02", inHand("upright.yaml")), 3) << said_;
  EXPECT_NE(said_.find("4-axis robot"), std::string::npos) << said_;
  EXPECT_NE(said_.find("board_z"), std::string::npos) << said_;
  const double z = (cell_.T_other_board * cell_.centre()).z();
  ASSERT_EQ(run("9x6", "0.02", inHand("upright.yaml") + " --board-z " + std::to_string(z)), 0)
      << said_;
  EXPECT_NE(said_.find("note: 4-axis robot"), std::string::npos) << said_;
  const HandEyeFile file = loadHandEye(out() + "/hand_eye.yaml");
  EXPECT_TRUE(isometryNear(file.T_parent_child, cell_.T_mount_camera, 4e-3, 0.4 * sim::kDegree));
  EXPECT_NE(read(out() + "/hand_eye.yaml").find("height is not from the pictures"),
            std::string::npos);
}

TEST_F(CalibrateSamples, TheirBoardIsDrawnToPrint) {
  const std::string pdf = dir_->path("board.pdf");
  const std::string tool = std::string(DRAW_BOARD) + " --output " + pdf;
  EXPECT_EQ(runTool(tool + " --board-file " PACKAGE_DIR "/config/board.yaml"), 0) << error_;
  EXPECT_NE(said_.find("written to " + pdf), std::string::npos) << said_;
  EXPECT_EQ(read(pdf).substr(0, 8), "%PDF-1.4");
  EXPECT_NE(read(pdf).find("DICT_4X4_50"), std::string::npos);
  EXPECT_EQ(runTool(tool + " --board 9x6 --square 0.02"), 0) << error_;
  EXPECT_NE(read(pdf).find("checkerboard, 9x6"), std::string::npos);
  EXPECT_TRUE(refused(runTool(tool), {"--board-file"}));
  EXPECT_TRUE(refused(runTool(tool + " --board 9x6"), {"--square"}));
  dir_->write("bad.yaml", "kind: charuco\ncorners: 9x6\nsquare: 0.02\n");
  EXPECT_TRUE(
      refused(runTool(tool + " --board-file " + dir_->path("bad.yaml")), {"bad.yaml", "marker"}));
}

TEST_F(CalibrateSamples, RefusesBadInputInOneLine) {
  EXPECT_TRUE(refused(run("9x6", "0.02", inHand() + " --replace-good maybe"),
                      {"--replace-good", "maybe", "yes,no"}));
  EXPECT_TRUE(refused(run("9x6", "zero", inHand()), {"--square", "zero"}));
  EXPECT_TRUE(refused(run("9-6", "0.02", inHand()), {"9-6", "9x6"}));
  EXPECT_TRUE(
      refused(run("9x6", "0.02", "--mode on_foot --samples x"), {"on_foot", "eye_in_hand"}));
  EXPECT_TRUE(refused(run("9x6", "0.02", "--mode eye_in_hand"), {"--samples", "required"}));
  EXPECT_TRUE(refused(run("9x6", "0.02", inHand() + " --colour red"), {"--colour"}));
  EXPECT_TRUE(
      refused(run("9x6", "0.02", inHand("absent.yaml")), {"absent.yaml", "cannot be read"}));
  const auto samples = [](const std::string& text) {
    dir_->write("bad.yaml", text);
    return inHand("bad.yaml");
  };
  EXPECT_TRUE(refused(run("9x6", "0.02", samples("image: x")), {"bad.yaml", "list"}));
  EXPECT_TRUE(refused(run("9x6", "0.02", samples("- &it {image: *it}")), {"bad.yaml", "alias"}));
  EXPECT_TRUE(refused(run("9x6", "0.02", samples("- {image: a, image: b}")), {"image", "twice"}));
  EXPECT_TRUE(refused(run("9x6", "0.02", samples("- {picture: a}")), {"unknown key", "picture"}));
  ASSERT_EQ(mkfifo(dir_->path("pipe").c_str(), 0600), 0);
  EXPECT_TRUE(refused(run("9x6", "0.02", inHand("pipe")), {"pipe", "no regular file"}));
  EXPECT_TRUE(refused(run("9x6", "0.02", inHand(".")), {"no regular file"}));
  EXPECT_TRUE(
      refused(run("9x6", "0.02",
                  samples("- {image: pipe, position: [0, 0, 1], orientation: [0, 0, 0, 1]}")),
              {"pipe", "no regular file"}));
  EXPECT_TRUE(refused(run("9x6", "0.02", samples("- {image: view0.png, position: [1, 2]}")),
                      {"sample 1", "position", "3 numbers"}));
  EXPECT_TRUE(
      refused(run("9x6", "0.02",
                  samples("- {image: view0.png, position: [1, 2, 3], orientation: [0, 0, 0, 2]}")),
              {"sample 1", "quaternion"}));
  EXPECT_TRUE(
      refused(run("9x6", "0.02",
                  samples("- {image: no.png, position: [1, 2, 3], orientation: [0, 0, 0, 1]}")),
              {"no.png", "cannot be read"}));
}

}  // namespace
}  // namespace planar_bin_picking
