// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_file.h"
#include "planar_bin_picking/image/camera_file.h"
#include "support/board_problem.h"
#include "support/comma_locale.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <yaml-cpp/yaml.h>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>

namespace planar_bin_picking {
namespace {

const char* const kFiles[] = {"report.html", "camera_info.yaml", "hand_eye.yaml",
                              "calibration.yaml"};

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

class CalibrationFile : public testing::Test {
 protected:
  CalibrationFile() {
    std::mt19937 random(7);
    const sim::BoardCell cell = sim::makeCell(true, &random);
    problem_ = randomProblem(cell, 10, &random);
    result_ = solveHandEye(problem_, {});
  }

  std::string out(const std::string& name = "") const { return dir_.path("out/" + name); }
  std::string save(bool replace_good = false) const {
    return saveCalibration(out(), problem_, result_, {"palm", "tool0", "eye"},
                           {replace_good, "2026-01-02T03:04:05Z", ""});
  }

  HandEyeProblem problem_;
  HandEyeResult result_;
  TempDir dir_;
};

TEST_F(CalibrationFile, ReadsWhatItWrote) {
  ASSERT_EQ(result_.verdict, Verdict::kGood);
  save();
  const HandEyeFile file = loadHandEye(out("hand_eye.yaml"));
  EXPECT_EQ(file.parent_frame, "tool0");
  EXPECT_EQ(file.child_frame, "eye");
  EXPECT_TRUE(isometryNear(file.T_parent_child, result_.T_mount_camera, 1e-9, 1e-8));
  EXPECT_EQ(file.verdict, "GOOD");
  EXPECT_EQ(file.date, "2026-01-02T03:04:05Z");
  EXPECT_EQ(file.camera_name, "palm");
  EXPECT_NEAR(file.expected_error_mm, result_.expected_error_mm, 1e-8);
  EXPECT_NEAR(file.expected_error_deg, result_.expected_error_deg, 1e-8);
  const Camera camera = loadCamera(out("camera_info.yaml"));
  EXPECT_NEAR(camera.model().fx, result_.camera.fx, 1e-5);
  EXPECT_EQ(camera.model().width, 2448);
}

// A process that reads and writes 1.234,5 writes the same bytes, and reads them.
TEST_F(CalibrationFile, KnowsNoLocale) {
  // One view does not belong to its pose: what is said of it has numbers, too.
  auto& T = problem_.observations[3].T_base_flange;
  T.linear() = T.linear() * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  result_ = solveHandEye(problem_, {});
  save();
  ASSERT_NE(read(out("calibration.yaml")).find("angles that differ by "), std::string::npos);
  std::vector<std::string> expected;
  for (const char* name : kFiles) expected.push_back(read(out(name)));
  const CommaLocale comma;
  result_ = solveHandEye(problem_, {});
  save();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(read(out(kFiles[i])), expected[i]) << kFiles[i];
  EXPECT_TRUE(isometryNear(loadHandEye(out("hand_eye.yaml")).T_parent_child, result_.T_mount_camera,
                           1e-9, 1e-8));
  EXPECT_NEAR(loadCamera(out("camera_info.yaml")).model().fx, result_.camera.fx, 1e-5);
  EXPECT_EQ(parseBoard("9x6", 0.02).cols, 9);
}

// Reasons have numbers, too: a robot that is far too noisy, a square that is far too large.
TEST_F(CalibrationFile, ReasonsKnowNoLocale) {
  problem_.board.square *= 1.1;
  std::mt19937 random(3);
  const auto texts = [this] {
    HandEyeParams params;
    params.working_distance = 1.5;
    result_ = solveHandEye(problem_, params);
    std::string all;
    for (const std::string& reason : result_.reasons) all += reason + "\n";
    try {
      validate(Board{9, 6, 12345.5});
    } catch (const std::invalid_argument& error) {
      all += error.what();
    }
    params.robot_poor_mm = 1234.5;
    try {
      validate(params);
    } catch (const std::invalid_argument& error) {
      all += error.what();
    }
    return all;
  };
  const std::string expected = texts();
  EXPECT_NE(expected.find('.'), std::string::npos);
  const CommaLocale comma;
  EXPECT_EQ(texts(), expected);
}

/// Of which calibrations the files are; more than one is a mixture.
std::set<std::string> namesIn(const std::string& folder) {
  std::set<std::string> names;
  std::smatch match;
  const std::string info = read(folder + "/camera_info.yaml");
  if (std::regex_search(info, match, std::regex("camera_name: (\\w+)"))) names.insert(match[1]);
  const std::string eye = read(folder + "/hand_eye.yaml");
  if (std::regex_search(eye, match, std::regex("child_frame: (\\w+)"))) names.insert(match[1]);
  return names;
}

// Files that cannot grow beyond a size: some of the set would fit, some would not.
TEST_F(CalibrationFile, FullDiskLeavesNoMixture) {
  saveCalibration(out(), problem_, result_, {"old", "flange", "old"});
  const std::string report = read(out("report.html"));
  int kept = 0, replaced = 0;
  for (rlim_t limit = 256; limit < (1 << 20); limit *= 2) {
    const pid_t child = fork();
    if (child == 0) {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit size{limit, limit};
      if (setrlimit(RLIMIT_FSIZE, &size) != 0) _exit(2);
      try {
        saveCalibration(out(), problem_, result_, {"new", "flange", "new"});
      } catch (const std::runtime_error&) {
        _exit(1);
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    const std::string expected = WEXITSTATUS(status) == 1 ? "old" : "new";
    ++(WEXITSTATUS(status) == 1 ? kept : replaced);
    ASSERT_NE(WEXITSTATUS(status), 2);
    if (replaced == 0) {
      EXPECT_EQ(namesIn(out()), std::set<std::string>{expected}) << limit;
    }
  }
  EXPECT_GT(kept, 3);
  EXPECT_GT(replaced, 0);
  EXPECT_EQ(namesIn(out()), std::set<std::string>{"new"});
}

TEST_F(CalibrationFile, SaysWhatIsInTheWayOfItsFolder) {
  const auto failure = [](const std::string& folder) -> std::string {
    try {
      checkCalibrationFolder(folder);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(failure(dir_.write("file", "x")).find("file: this folder"), std::string::npos);
  ASSERT_EQ(mkfifo(dir_.path("pipe").c_str(), 0600), 0);
  EXPECT_NE(failure(dir_.path("pipe")).find("pipe: this folder"), std::string::npos);
  EXPECT_NE(failure(dir_.path("pipe/below")).find("below: this folder"), std::string::npos);
  EXPECT_EQ(failure(dir_.path("two/deep")), "");
  EXPECT_TRUE(std::filesystem::is_empty(dir_.path("two/deep")));
  std::filesystem::create_symlink(dir_.path("nowhere"), dir_.path("link"));
  EXPECT_NE(failure(dir_.path("link")), "");
}

TEST_F(CalibrationFile, SaysWhenAndWhatItIsWorth) {
  save();
  for (const char* name : kFiles) {
    EXPECT_NE(read(out(name)).find("2026-01-02T03:04:05Z"), std::string::npos) << name;
    EXPECT_NE(read(out(name)).find("palm"), std::string::npos) << name;
    EXPECT_NE(read(out(name)).find("GOOD"), std::string::npos) << name;
  }
  const YAML::Node eye = YAML::LoadFile(out("hand_eye.yaml"));
  ASSERT_EQ(eye["covariance"].size(), 36u);
  EXPECT_NEAR(eye["covariance"][7].as<double>(), result_.covariance(kHandEye + 1, kHandEye + 1),
              1e-15);
  EXPECT_EQ(eye["board_transform"]["name"].as<std::string>(), "T_base_board");
  EXPECT_NEAR(eye["board_transform"]["position"][0].as<double>(),
              result_.T_other_board.translation().x(), 1e-9);
  // Without a date given it is today's.
  saveCalibration(out("now"), problem_, result_, {});
  EXPECT_EQ(loadHandEye(out("now/hand_eye.yaml")).date.substr(0, 2), "20");
}

// The same transform for who does not read hand_eye.yaml.
TEST_F(CalibrationFile, WritesLaunchAndXacro) {
  save();
  const std::string launch = read(out("static_transform.launch"));
  std::smatch match;
  ASSERT_TRUE(std::regex_search(launch, match, std::regex("args=\"([^\"]*)\"")));
  std::istringstream args(match[1]);
  Eigen::Vector3d p;
  Eigen::Quaterniond q;
  std::string parent, child;
  args >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w() >> parent >> child;
  EXPECT_EQ(parent, "tool0");
  EXPECT_EQ(child, "eye");
  EXPECT_TRUE(isometryNear(rigid(q.toRotationMatrix(), p), result_.T_mount_camera, 1e-8, 1e-7));
  const std::string xacro = read(out("hand_eye.xacro"));
  ASSERT_TRUE(std::regex_search(xacro, match, std::regex("rpy=\"(\\S+) (\\S+) (\\S+)\"")));
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(std::stod(match[3]), Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(std::stod(match[2]), Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(std::stod(match[1]), Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  EXPECT_TRUE(isometryNear(rigid(R, p), result_.T_mount_camera, 1e-8, 1e-7));
}

// XML has no "--" within a comment, and a new line ends one of YAML.
TEST_F(CalibrationFile, AnyNameOfACameraIsOneComment) {
  saveCalibration(out(), problem_, result_, {"left--<eye>\nfx: 1", "tool0", "eye"});
  for (const char* name : {"static_transform.launch", "hand_eye.xacro"}) {
    const std::string text = read(out(name));
    const auto begin = text.find("<!-- ") + 5, end = text.find(" -->");
    ASSERT_LT(begin, end) << text;
    const std::string comment = text.substr(begin, end - begin);
    EXPECT_EQ(comment.find("camera 'left- -&lt;eye&gt; fx: 1', calibrated 20"), 0u) << comment;
    EXPECT_EQ(comment.find("--"), std::string::npos) << comment;
  }
  EXPECT_NEAR(loadCamera(out("camera_info.yaml")).model().fx, result_.camera.fx, 1e-5);
  EXPECT_EQ(loadHandEye(out("hand_eye.yaml")).camera_name, "left--<eye>\nfx: 1");
}

TEST_F(CalibrationFile, PoorDoesNotReplaceGoodUnlessTold) {
  EXPECT_EQ(save(), out());
  const std::string good = read(out("hand_eye.yaml"));
  result_.verdict = Verdict::kPoor;
  EXPECT_EQ(save(), out() + "/poor");
  EXPECT_EQ(read(out("hand_eye.yaml")), good);
  EXPECT_EQ(loadHandEye(out("poor/hand_eye.yaml")).verdict, "POOR");
  EXPECT_EQ(save(true), out());
  EXPECT_EQ(loadHandEye(out("hand_eye.yaml")).verdict, "POOR");
  // A POOR one replaces a POOR one.
  EXPECT_EQ(save(), out());
}

TEST_F(CalibrationFile, RefusedLeavesNoOlderOneLookingValid) {
  save();
  result_.verdict = Verdict::kRefused;
  save();
  for (const char* name :
       {"hand_eye.yaml", "camera_info.yaml", "hand_eye.xacro", "static_transform.launch"}) {
    EXPECT_FALSE(std::filesystem::exists(out(name))) << name;
    EXPECT_TRUE(std::filesystem::exists(out(name) + ".before")) << name;
  }
  EXPECT_NE(read(out("calibration.yaml")).find("REFUSED"), std::string::npos);
}

// Files of older versions have no date and no verdict.
TEST_F(CalibrationFile, ReadsOlderFiles) {
  const HandEyeFile file = loadHandEye(dir_.write(
      "old.yaml",
      "{parent_frame: a, child_frame: b, position: [1, 2, 3], orientation: [0, 0, 0, 1]}"));
  EXPECT_EQ(file.verdict, "");
  EXPECT_EQ(file.expected_error_mm, 0.0);
}

TEST_F(CalibrationFile, RefusedIsWrittenWithoutCamera) {
  result_.verdict = Verdict::kRefused;
  save();
  EXPECT_TRUE(std::filesystem::exists(out("calibration.yaml")));
  EXPECT_TRUE(std::filesystem::exists(out("report.html")));
  EXPECT_FALSE(std::filesystem::exists(out("hand_eye.yaml")));
  EXPECT_FALSE(std::filesystem::exists(out("camera_info.yaml")));
}

}  // namespace
}  // namespace planar_bin_picking
