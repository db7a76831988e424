// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"
#include "support/board_problem.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace planar_bin_picking {
namespace {

std::string joined(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) out += line + "\n";
  return out;
}

/// REFUSED, with all of `words` in its reasons.
testing::AssertionResult refusedFor(const HandEyeResult& result,
                                    const std::vector<std::string>& words) {
  const std::string reasons = joined(result.reasons);
  bool good = result.verdict == Verdict::kRefused;
  for (const std::string& word : words) good = good && reasons.find(word) != std::string::npos;
  return (good ? testing::AssertionSuccess() : testing::AssertionFailure())
         << nameOf(result.verdict) << ": " << reasons;
}

Camera::Model trueCamera(const sim::BoardCell& cell) {
  Camera::Model camera;
  camera.width = cell.camera.width;
  camera.height = cell.camera.height;
  camera.fx = cell.camera.fx;
  camera.fy = cell.camera.fy;
  camera.cx = cell.camera.cx;
  camera.cy = cell.camera.cy;
  camera.distortion.assign(cell.camera.lens.begin(), cell.camera.lens.end());
  return camera;
}

class HandEye : public testing::TestWithParam<bool> {
 protected:
  HandEye() : cell_(sim::makeCell(GetParam(), &random_)) {}
  std::mt19937 random_{7};
  sim::BoardCell cell_;
};

TEST_P(HandEye, FindsTheCameraWithAnExactRobot) {
  const HandEyeResult result = solveHandEye(randomProblem(cell_, 15, &random_), {});
  EXPECT_EQ(result.verdict, Verdict::kGood) << joined(result.reasons);
  EXPECT_TRUE(isometryNear(result.T_mount_camera, cell_.T_mount_camera, 1e-4, 0.01 * sim::kDegree));
  EXPECT_TRUE(isometryNear(result.T_other_board, cell_.T_other_board, 1e-4, 0.01 * sim::kDegree));
  EXPECT_NEAR(result.camera.fx / cell_.camera.fx, 1.0, 2e-4);
  EXPECT_NEAR(result.camera.fy / cell_.camera.fy, 1.0, 2e-4);
  EXPECT_NEAR(result.square_ratio, 1.0, 4.0 * result.square_ratio_sigma);
  // 54 corners leave the noise of 0.05 px per coordinate well visible.
  EXPECT_NEAR(result.sigma_px, cell_.corner_px, 0.1 * cell_.corner_px);
  EXPECT_LT(result.robot_mm, 0.03);
  EXPECT_EQ(result.views_used, 15);
  EXPECT_EQ(result.transform_name, GetParam() ? "T_flange_camera" : "T_base_camera");
}

TEST_P(HandEye, SaysHowNoisyTheRobotIs) {
  cell_.robot_mm = 1.0;
  cell_.robot_deg = 0.1;
  HandEyeParams params;
  params.robot_poor_mm = 0.5;
  const HandEyeResult result = solveHandEye(randomProblem(cell_, 25, &random_), params);
  EXPECT_EQ(result.verdict, Verdict::kPoor);
  EXPECT_NE(joined(result.reasons).find("robot"), std::string::npos) << joined(result.reasons);
  // 25 views x 3 axes minus what the solution takes: the spread is known to some 10 %.
  EXPECT_NEAR(result.robot_mm, 1.0, 0.3);
  EXPECT_NEAR(result.robot_deg, 0.1, 0.03);
  EXPECT_GT(result.chain_px, 5.0 * result.pnp_floor_px);
  EXPECT_NEAR(result.rms_px, result.pnp_floor_px, 0.2 * result.pnp_floor_px);
  EXPECT_GT(result.leave_one_out_mm, 0.0);
}

TEST_P(HandEye, TellsTheTrueSquare) {
  HandEyeProblem problem = randomProblem(cell_, 15, &random_);
  problem.board.square = 2.0 * cell_.square;
  const HandEyeResult result = solveHandEye(problem, {});
  EXPECT_TRUE(refusedFor(result, {"square size wrong", "40 mm", "20 mm"}));
  EXPECT_NEAR(result.square_ratio, 0.5, 0.005);
}

TEST_P(HandEye, RefusesRotationsAboutOneAxis) {
  HandEyeProblem problem = emptyProblem(cell_);
  const Eigen::Isometry3d first = cell_.flangeFor(rigid(
      Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix(), {-0.08, -0.05, 0.5}));
  for (int i = 0; i < 12; ++i) {
    Eigen::Isometry3d turned = first;
    const Eigen::Vector3d axis =
        first.linear().transpose() * (cell_.in_hand ? cell_.T_other_board.linear().col(2)
                                                    : cell_.T_mount_camera.linear().col(2));
    turned.linear() = first.linear() * Eigen::AngleAxisd(0.05 * (i - 6), axis).toRotationMatrix();
    addObservation(cell_, turned, &random_, &problem);
  }
  ASSERT_GE(problem.observations.size(), 8u);
  EXPECT_TRUE(refusedFor(solveHandEye(problem, {}), {"one axis"}));
}

TEST_P(HandEye, LeavesOutWrongPairs) {
  HandEyeProblem problem = randomProblem(cell_, 16, &random_);
  std::swap(problem.observations[3].T_base_flange, problem.observations[9].T_base_flange);
  // Still moving when the picture was taken: too little for the angles to tell.
  problem.observations[12].T_base_flange.translation().x() += 0.004;
  const HandEyeResult result = solveHandEye(problem, {});
  EXPECT_FALSE(result.views[3].used);
  EXPECT_FALSE(result.views[9].used);
  EXPECT_FALSE(result.views[12].used);
  EXPECT_NE(result.views[3].why_not.find("angles"), std::string::npos);
  EXPECT_NE(result.views[12].why_not.find("mm"), std::string::npos);
  EXPECT_EQ(result.views_used, 13);
  EXPECT_TRUE(isometryNear(result.T_mount_camera, cell_.T_mount_camera, 2e-4, 0.02 * sim::kDegree));
}

TEST_P(HandEye, RefusesStalePoses) {
  const HandEyeProblem problem = randomProblem(cell_, 14, &random_);
  HandEyeProblem late = problem;
  for (std::size_t i = 1; i < 14; ++i) {
    late.observations[i].T_base_flange = problem.observations[i - 1].T_base_flange;
  }
  EXPECT_TRUE(refusedFor(solveHandEye(late, {}), {"tf is stale"}));
  HandEyeProblem frozen = problem;
  for (std::size_t i = 5; i < 14; ++i) {
    frozen.observations[i].T_base_flange = problem.observations[4].T_base_flange;
  }
  EXPECT_TRUE(refusedFor(solveHandEye(frozen, {}), {"tf is stale", "view 5"}));
}

TEST_P(HandEye, RefusesTooFewViewsAndNoise) {
  EXPECT_TRUE(refusedFor(solveHandEye(randomProblem(cell_, 2, &random_), {}), {"too few views"}));
  EXPECT_TRUE(refusedFor(solveHandEye(randomProblem(cell_, 5, &random_), {}), {"too few views"}));
  EXPECT_TRUE(refusedFor(solveHandEye(emptyProblem(cell_), {}), {"too few views: 0"}));
  cell_.robot_mm = 10.0;
  cell_.robot_deg = 0.8;
  EXPECT_TRUE(refusedFor(solveHandEye(randomProblem(cell_, 20, &random_), {}), {"robot noise"}));
}

TEST_P(HandEye, RefusesTheOtherMounting) {
  HandEyeProblem problem = randomProblem(cell_, 15, &random_);
  problem.mounting = GetParam() ? Mounting::kEyeToHand : Mounting::kEyeInHand;
  EXPECT_EQ(solveHandEye(problem, {}).verdict, Verdict::kRefused);
}

TEST_P(HandEye, RefusesInvertedPoses) {
  HandEyeProblem problem = randomProblem(cell_, 15, &random_);
  for (Observation& observation : problem.observations) {
    observation.T_base_flange = observation.T_base_flange.inverse();
  }
  EXPECT_EQ(solveHandEye(problem, {}).verdict, Verdict::kRefused);
}

TEST_P(HandEye, SortsOutBoardsThatLookTheSameTurned) {
  for (const auto& [cols, rows] : {std::pair(8, 6), {7, 5}, {6, 6}}) {
    cell_.cols = cols;
    cell_.rows = rows;
    HandEyeProblem problem = randomProblem(cell_, 15, &random_);
    const auto all = orderings(problem.board);
    ASSERT_EQ(all.size(), cols == rows ? 4u : 2u);
    for (std::size_t i = 0; i < problem.observations.size(); ++i) {
      std::vector<Eigen::Vector2d>& corners = problem.observations[i].corners;
      const std::vector<Eigen::Vector2d> before = corners;
      for (std::size_t k = 0; k < corners.size(); ++k) {
        corners[k] = before[all[(i * i) % all.size()][k]];
      }
    }
    const HandEyeResult result = solveHandEye(problem, {});
    EXPECT_EQ(result.verdict, Verdict::kGood)
        << cols << "x" << rows << " " << joined(result.reasons);
    EXPECT_TRUE(
        isometryNear(result.T_mount_camera, cell_.T_mount_camera, 2e-4, 0.02 * sim::kDegree));
  }
}

TEST_P(HandEye, HoldsAGivenCamera) {
  HandEyeProblem problem = randomProblem(cell_, 10, &random_);
  problem.camera = trueCamera(cell_);
  const HandEyeResult result = solveHandEye(problem, {});
  EXPECT_EQ(result.verdict, Verdict::kGood) << joined(result.reasons);
  EXPECT_EQ(result.camera.fx, problem.camera->fx);
  EXPECT_EQ(result.covariance.leftCols(kHandEye).norm(), 0.0);
  EXPECT_EQ(result.own_camera_px, 0.0);
  EXPECT_TRUE(isometryNear(result.T_mount_camera, cell_.T_mount_camera, 1e-4, 0.01 * sim::kDegree));
}

TEST_P(HandEye, HoldsAGivenRationalCamera) {
  HandEyeProblem problem = randomProblem(cell_, 12, &random_);
  Camera::Model model = trueCamera(cell_);
  model.distortion_model = "rational_polynomial";
  model.distortion.insert(model.distortion.end(), {0.2, -0.1, 0.05});
  const Camera camera(model);
  for (Observation& observation : problem.observations) {
    const Eigen::Isometry3d T_camera_board = cell_.cameraBoard(observation.T_base_flange);
    for (std::size_t i = 0; i < observation.corners.size(); ++i) {
      observation.corners[i] = camera.project(T_camera_board * problem.board.corner(i));
    }
  }
  problem.camera = model;
  const HandEyeResult result = solveHandEye(problem, {});
  EXPECT_EQ(result.verdict, Verdict::kGood) << joined(result.reasons);
  EXPECT_LT(result.rms_px, 1e-3);
  EXPECT_EQ(result.camera.distortion, model.distortion);
  EXPECT_TRUE(isometryNear(result.T_mount_camera, cell_.T_mount_camera, 1e-5, 1e-3 * sim::kDegree));
}

// Without the widening the mean square is five variances, and own_camera_px stays 0.
TEST_P(HandEye, AllowsForAGivenCameraThatThePicturesContradict) {
  double squares = 0.0;
  constexpr int kProblems = 6;
  std::normal_distribution<double> normal;
  for (int i = 0; i < kProblems; ++i) {
    HandEyeProblem problem = randomProblem(cell_, 15, &random_);
    problem.camera = trueCamera(cell_);
    problem.camera->fx += 2.0 * normal(random_);
    problem.camera->cx += 2.0 * normal(random_);
    problem.camera->cy += 2.0 * normal(random_);
    const HandEyeResult result = solveHandEye(problem, {});
    ASSERT_TRUE(result.solved) << joined(result.reasons);
    EXPECT_EQ(result.camera.cx, problem.camera->cx);
    EXPECT_GT(result.own_camera_px, 0.0);
    const Vector6d error = log(result.T_mount_camera.inverse() * cell_.T_mount_camera);
    squares +=
        error.head<3>().squaredNorm() / result.covariance.block<3, 3>(kHandEye, kHandEye).trace();
  }
  EXPECT_NEAR(std::log(squares / kProblems), 0.0, std::log(4.0));
}

TEST_P(HandEye, NamesAGivenCameraThatDoesNotFit) {
  HandEyeProblem problem = randomProblem(cell_, 15, &random_);
  problem.camera = trueCamera(cell_);
  problem.camera->distortion.assign(5, 0.0);
  const HandEyeResult result = solveHandEye(problem, {});
  EXPECT_NE(result.verdict, Verdict::kGood);
  EXPECT_NE(joined(result.reasons).find("given camera does not fit"), std::string::npos)
      << joined(result.reasons);
}

TEST_P(HandEye, IsTheSameEveryTime) {
  cell_.robot_mm = 0.2;
  cell_.robot_deg = 0.02;
  const HandEyeProblem problem = randomProblem(cell_, 10, &random_);
  const HandEyeResult a = solveHandEye(problem, {}), b = solveHandEye(problem, {});
  EXPECT_TRUE(a.T_mount_camera.matrix() == b.T_mount_camera.matrix());
  EXPECT_TRUE(a.covariance == b.covariance);
}

INSTANTIATE_TEST_SUITE_P(BothMountings, HandEye, testing::Bool(),
                         [](const auto& info) { return info.param ? "EyeInHand" : "EyeToHand"; });

// The stated sigma against what really happens: over 20 cells the mean squared error in units of
// sigma.
TEST(HandEyeSigma, IsHonest) {
  for (const auto& [mm, deg] : {std::pair(0.0, 0.0), {0.1, 0.02}, {1.0, 0.1}}) {
    double translation = 0.0, rotation = 0.0;
    constexpr int kCells = 10;
    for (int seed = 0; seed < kCells; ++seed) {
      std::mt19937 random(static_cast<unsigned>(seed) + 100);
      sim::BoardCell cell = sim::makeCell(seed % 2 == 0, &random);
      cell.robot_mm = mm;
      cell.robot_deg = deg;
      const HandEyeResult result = solveHandEye(randomProblem(cell, 15, &random), {});
      ASSERT_TRUE(result.solved);
      const Vector6d error = log(result.T_mount_camera.inverse() * cell.T_mount_camera);
      const Matrix6d covariance = result.covariance.block<6, 6>(kHandEye, kHandEye);
      translation +=
          error.head<3>().dot(covariance.topLeftCorner<3, 3>().inverse() * error.head<3>());
      rotation +=
          error.tail<3>().dot(covariance.bottomRightCorner<3, 3>().inverse() * error.tail<3>());
    }
    // 3 degrees of freedom; the mean over 10 cells is known to 26 %, and a factor of two in sigma
    // would be four here.
    EXPECT_NEAR(std::log(translation / kCells / 3.0), 0.0, std::log(2.0)) << mm << " mm";
    EXPECT_NEAR(std::log(rotation / kCells / 3.0), 0.0, std::log(2.0)) << deg << " deg";
  }
}

/// Moves each view's corners by a smooth field of its own, as a board that bends or uneven light
/// do.
void bendViews(double bend_px, std::mt19937* random, HandEyeProblem* problem) {
  std::normal_distribution<double> normal(0.0, bend_px);
  for (Observation& observation : problem->observations) {
    Eigen::Matrix<double, 2, 3> field;
    for (int i = 0; i < field.size(); ++i) field(i) = normal(*random);
    for (std::size_t i = 0; i < observation.corners.size(); ++i) {
      const Eigen::Vector3d x = problem->board.corner(i) / problem->board.corner(53).x();
      observation.corners[i] +=
          field * Eigen::Vector3d(x.x() * x.x(), x.x() * x.y(), x.y() * x.y());
    }
  }
}

// Taken for independent, the corners promise so much that the mean square is 7 variances, of fx 28.
TEST(HandEyeSigma, IsHonestWhereTheErrorsOfAViewAreCorrelated) {
  double translation = 0.0, fx = 0.0;
  constexpr int kCells = 8;
  for (int seed = 0; seed < kCells; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed) + 300);
    const sim::BoardCell cell = sim::makeCell(seed % 2 == 0, &random);
    HandEyeProblem problem = randomProblem(cell, 15, &random);
    bendViews(0.5, &random, &problem);
    const HandEyeResult result = solveHandEye(problem, {});
    ASSERT_TRUE(result.solved);
    const Vector6d error = log(result.T_mount_camera.inverse() * cell.T_mount_camera);
    translation +=
        error.head<3>().squaredNorm() / result.covariance.block<3, 3>(kHandEye, kHandEye).trace();
    fx += std::pow(result.camera.fx - cell.camera.fx, 2) / result.covariance(0, 0);
  }
  EXPECT_NEAR(std::log(translation / kCells), 0.0, std::log(4.0));
  EXPECT_NEAR(std::log(fx / kCells), 0.0, std::log(4.0));
}

TEST(HandEyeInput, IsChecked) {
  std::mt19937 random(1);
  const sim::BoardCell cell = sim::makeCell(true, &random);
  const HandEyeProblem problem = randomProblem(cell, 4, &random);
  const auto refused = [&](auto change, const std::vector<std::string>& words) {
    HandEyeProblem changed = problem;
    HandEyeParams params;
    change(&changed, &params);
    return refuses([&] { solveHandEye(changed, params); }, words);
  };
  EXPECT_TRUE(refused([](auto* p, auto*) { p->board.cols = 1; }, {"cols", "1", "inner corners"}));
  EXPECT_TRUE(refused([](auto* p, auto*) { p->board.square = 20.0; }, {"square", "20", "metres"}));
  EXPECT_TRUE(refused([](auto* p, auto*) { p->board.cols = 8; }, {"view 1", "54", "48"}));
  EXPECT_TRUE(refused([](auto* p, auto*) { p->width = 0; }, {"image size"}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(
      refused([nan](auto* p, auto*) { p->observations[2].corners[3].x() = nan; }, {"view 3"}));
  EXPECT_TRUE(refused([](auto* p, auto*) { p->observations[1].T_base_flange.linear() *= 1.1; },
                      {"view 2", "rigid"}));
  EXPECT_TRUE(refused([](auto*, auto* q) { q->tolerance_mm = -1.0; }, {"tolerance_mm", "-1"}));
  EXPECT_TRUE(
      refused([](auto*, auto* q) { q->robot_sigma_mm = 1.0; }, {"robot_sigma_deg", "both"}));
  Camera::Model small;
  small.width = 640;
  small.height = 480;
  small.fx = small.fy = 600.0;
  EXPECT_TRUE(refused([&](auto* p, auto*) { p->camera = small; }, {"640", "2448"}));
}

}  // namespace
}  // namespace planar_bin_picking
