// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// Runs the program on pictures that are drawn here: its exit status and what it writes.

#include "planar_bin_picking/calibrate/calibration_file.h"
#include "planar_bin_picking/image/camera_file.h"
#include "sim/board_cell.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <yaml-cpp/yaml.h>
#include <opencv2/imgcodecs.hpp>

#include <cstdlib>
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
    std::ostringstream samples;
    std::vector<Eigen::Vector2d> corners;
    for (int i = 0; i < 12;) {
      const auto T_camera_board = sim::randomView(cell_, 0.42, 35.0, 0.5, &random);
      if (!sim::seeCorners(cell_, T_camera_board, &random, &corners)) continue;
      const std::string name = "view" + std::to_string(i++) + ".png";
      cv::imwrite(dir_->path(name), sim::takeBoardImage(cell_, T_camera_board, 0.7, 2.0, i));
      const Eigen::Isometry3d T = cell_.flangeFor(T_camera_board);
      const Eigen::Quaterniond q(T.linear());
      samples.precision(12);
      samples << "- {image: " << name << ", position: [" << T.translation().x() << ", "
              << T.translation().y() << ", " << T.translation().z() << "], orientation: [" << q.x()
              << ", " << q.y() << ", " << q.z() << ", " << q.w() << "]}\n";
    }
    samples_ = samples.str();
    dir_->write("samples.yaml", samples_);
  }
  static void TearDownTestSuite() { delete dir_; }

  static std::string read(const std::string& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  int run(const std::string& board, const std::string& square, const std::string& more) {
    const std::string error = dir_->path("error.txt");
    const int status =
        std::system((std::string(CALIBRATE_SAMPLES) + " --board " + board + " --square " + square +
                     " --output " + out() + " " + more + " >/dev/null 2>" + error)
                        .c_str());
    error_ = read(error);
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
  std::string error_;
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
