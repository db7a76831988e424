// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/robot/robot_line.h"

#include "support/comma_locale.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

RobotCommand parse(const std::string& line) { return parseRobotLine(line, PoseConvention::kKuka); }

TEST(RobotLine, ReadsEachCommand) {
  EXPECT_EQ(parse("hello").kind, RobotCommand::Kind::kHello);
  EXPECT_EQ(parse(" NEXT ").kind, RobotCommand::Kind::kNext);
  EXPECT_TRUE(parse("report OK").success);
  EXPECT_FALSE(parse("report failed").success);
  const RobotCommand all = parse("LOCATE *");
  EXPECT_EQ(all.kind, RobotCommand::Kind::kLocate);
  EXPECT_TRUE(all.parts.empty());
  EXPECT_FALSE(all.T_base_flange.has_value());
  const RobotCommand one = parse("locate Bracket lever back flange 500 0 800.5 0 90 180");
  EXPECT_EQ(one.parts, (std::vector<std::string>{"Bracket", "lever"}));
  EXPECT_EQ(one.face, FaceFilter::kBack);
  ASSERT_TRUE(one.T_base_flange.has_value());
  EXPECT_NEAR(one.T_base_flange->translation().z(), 0.8005, 1e-12);
}

TEST(RobotLine, ReadsTheStepsOfACalibration) {
  EXPECT_EQ(parse("calibrate START").step, "start");
  for (const char* const step : kCalibrateSteps) {
    const RobotCommand command = parse(std::string("calibrate ") + step);
    EXPECT_EQ(command.kind, RobotCommand::Kind::kCalibrate);
    EXPECT_EQ(command.step, step);
  }
  EXPECT_TRUE(refuses([] { parse("calibrate"); }, {"start", "verify"}));
  EXPECT_TRUE(refuses([] { parse("calibrate start now"); }, {"one word"}));
  EXPECT_TRUE(refuses([] { parse("calibrate ../../shutdown"); }, {"one word"}));
}

TEST(RobotLine, RefusesAllElse) {
  EXPECT_TRUE(refuses([] { parse(""); }, {"known are"}));
  EXPECT_TRUE(refuses([] { parse("GET / HTTP/1.1"); }, {"get", "known are"}));
  EXPECT_TRUE(refuses([] { parse("report"); }, {"ok or failed"}));
  EXPECT_TRUE(refuses([] { parse("report ok ok"); }, {"ok or failed"}));
  EXPECT_TRUE(refuses([] { parse("next 3"); }, {"no further"}));
  EXPECT_TRUE(refuses([] { parse("locate a flange 1 2 3"); }, {"6 numbers"}));
  EXPECT_TRUE(refuses([] { parse("locate a flange 1 2 3 4 5 six"); }, {"six"}));
  EXPECT_TRUE(refuses([] { parse("locate a flange 1 2 3 4 5 nan"); }, {"nan"}));
  EXPECT_TRUE(refuses([] { parse("locate a flange 1 2 3 4 5 6,5"); }, {"6,5"}));
  EXPECT_TRUE(refuses([] { parse(std::string("locate\0a", 8)); }, {"control"}));
}

TEST(RobotLine, WritesPosesForEachController) {
  const CommaLocale commas;
  RobotPose pose;
  pose.T_base_target.translation() = Eigen::Vector3d(0.5, -0.25, 0.0);
  pose.T_base_target.linear() =
      Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.left = 3, pose.face = Face::kBack, pose.part = "lever", pose.pick = "web";
  EXPECT_EQ(poseLine(pose, PoseConvention::kKuka),
            "0 3 2 500.000000 -250.000000 0.000000 90.000000 0.000000 0.000000 lever web\n");
  EXPECT_EQ(poseLine(pose, PoseConvention::kUr),
            "(0,3,2,0.500000,-0.250000,0.000000,0.000000,0.000000,1.570796)\n");
  pose.part = "le v\xC3\xA9";
  EXPECT_NE(poseLine(pose, PoseConvention::kKuka).find(" le?v?? web\n"), std::string::npos);
  pose.part = "lever";
  pose.T_base_approach = pose.T_base_target;
  EXPECT_EQ(poseLine(pose, PoseConvention::kUr),
            "(0,3,2,0.500000,-0.250000,0.000000,0.000000,0.000000,1.570796,"
            "0.500000,-0.250000,0.000000,0.000000,0.000000,1.570796)\n");
  pose.T_base_approach.reset();
  pose.T_base_retreat = Eigen::Isometry3d::Identity();
  pose.numbers = {12, 4};
  EXPECT_EQ(poseLine(pose, PoseConvention::kFanuc),
            "0 3 2 12 4 500.000000 -250.000000 0.000000 0.000000 0.000000 90.000000 "
            "0.000000 0.000000 0.000000 0.000000 0.000000 0.000000 lever web\n");
}

TEST(RobotLine, WritesTextsAsOneLineOfAscii) {
  EXPECT_EQ(textLine(RobotCode::kEmpty, "a\nb \xC3\xA9", PoseConvention::kAbb, 9), "2 a?b ??\n");
  EXPECT_EQ(textLine(RobotCode::kEmpty, "a", PoseConvention::kUr, 4), "(2,0,0,0)\n");
  EXPECT_LT(textLine(RobotCode::kSetUp, std::string(5000, 'x'), PoseConvention::kAbb, 9).size(),
            250u);
}

}  // namespace
}  // namespace planar_bin_picking
