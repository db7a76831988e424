// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_check.h"
#include "support/board_problem.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

using Finding = CalibrationCheck::Finding;

Eigen::Isometry3d shift(double mm, double deg) {
  Vector6d xi = Vector6d::Zero();
  xi[0] = 0.8e-3 * mm;
  xi[2] = 0.6e-3 * mm;
  xi[4] = deg * sim::kDegree;
  return exp(xi);
}

/// A calibration of 15 views, and then something happens to the cell.
class CalibrationCheckTest : public testing::TestWithParam<bool> {
 protected:
  void calibrate(unsigned seed) {
    random_.seed(seed);
    cell_ = sim::makeCell(GetParam(), &random_);
    cell_.robot_mm = 0.1;
    cell_.robot_deg = 0.02;
    problem_ = randomProblem(cell_, 15, &random_);
    result_ = solveHandEye(problem_, {});
    ASSERT_EQ(result_.verdict, Verdict::kGood);
  }
  CalibrationCheck check(int views) {
    return checkCalibration(problem_, result_, randomProblem(cell_, views, &random_).observations);
  }

  std::mt19937 random_;
  sim::BoardCell cell_;
  HandEyeProblem problem_;
  HandEyeResult result_;
};

TEST_P(CalibrationCheckTest, HoldsWhereNothingMoved) {
  int wrong = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    calibrate(seed);
    for (int views = 1; views <= 3; ++views) {
      const CalibrationCheck found = check(views);
      wrong += found.finding == Finding::kHolds ? 0 : 1;
      EXPECT_TRUE(found.finding != Finding::kHolds || found.moved_mm < found.expected_mm);
    }
  }
  EXPECT_LE(wrong, 1);  // of 18; one in a thousand is expected
}

TEST_P(CalibrationCheckTest, TellsCameraFromBoard) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    calibrate(seed);
    const Eigen::Isometry3d mount = cell_.T_mount_camera;
    cell_.T_mount_camera = mount * shift(4.0, 0.8);
    const CalibrationCheck camera = check(3);
    EXPECT_EQ(camera.finding, Finding::kCameraMoved) << camera.text;
    EXPECT_FALSE(camera.holds());
    EXPECT_NEAR(camera.moved_mm, 4.0, 1.0);
    EXPECT_NEAR(camera.moved_deg, 0.8, 0.1);
    EXPECT_LT(camera.expected_mm, 2.0);
    EXPECT_NE(camera.text.find("camera has moved on its mount by"), std::string::npos);
    cell_.T_mount_camera = mount;
    cell_.T_other_board = cell_.T_other_board * shift(15.0, 4.0);
    const CalibrationCheck board = check(3);
    EXPECT_EQ(board.finding, Finding::kBoardMoved) << board.text;
    EXPECT_TRUE(board.holds());
    EXPECT_NEAR(board.moved_mm, 15.0, 1.0);
    EXPECT_NEAR(board.moved_deg, 4.0, 0.2);
  }
}

TEST_P(CalibrationCheckTest, OneViewSaysThatSomethingMoved) {
  calibrate(4);
  cell_.T_mount_camera = cell_.T_mount_camera * shift(6.0, 1.0);
  const CalibrationCheck found = check(1);
  EXPECT_EQ(found.finding, Finding::kCameraOrBoard) << found.text;
  EXPECT_FALSE(found.holds());
  EXPECT_NE(found.text.find("a further view"), std::string::npos) << found.text;
}

TEST_P(CalibrationCheckTest, LensThatWasTurned) {
  calibrate(5);
  cell_.camera.fx *= 1.03;
  cell_.camera.fy *= 1.03;
  const CalibrationCheck found = check(3);
  EXPECT_EQ(found.finding, Finding::kLensChanged) << found.text;
  EXPECT_NEAR(found.focal_percent, 3.0, 0.5);
}

// A robot that lost its reference differs from view to view.
TEST_P(CalibrationCheckTest, WhatNothingExplains) {
  calibrate(6);
  std::vector<Observation> views = randomProblem(cell_, 3, &random_).observations;
  views[0].T_base_flange = views[0].T_base_flange * shift(60.0, 0.0);
  views[1].T_base_flange = views[1].T_base_flange * shift(0.0, 10.0);
  const CalibrationCheck found = checkCalibration(problem_, result_, views);
  EXPECT_EQ(found.finding, Finding::kUnexplained) << found.text;
  EXPECT_FALSE(found.holds());
}

INSTANTIATE_TEST_SUITE_P(BothMountings, CalibrationCheckTest, testing::Bool());

TEST(CalibrationCheckInput, IsChecked) {
  std::mt19937 random(1);
  const sim::BoardCell cell = sim::makeCell(true, &random);
  const HandEyeProblem problem = randomProblem(cell, 15, &random);
  const HandEyeResult result = solveHandEye(problem, {});
  std::vector<Observation> views = problem.observations;
  EXPECT_TRUE(refuses([&] { checkCalibration(problem, result, {}); }, {"1 to 3 views", "0"}));
  EXPECT_TRUE(refuses([&] { checkCalibration(problem, result, views); }, {"15"}));
  views.resize(1);
  EXPECT_TRUE(refuses([&] { checkCalibration(problem, {}, views); }, {"no solution"}));
  views[0].corners.pop_back();
  EXPECT_TRUE(refuses([&] { checkCalibration(problem, result, views); }, {"view 1", "54"}));
}

}  // namespace
}  // namespace planar_bin_picking
