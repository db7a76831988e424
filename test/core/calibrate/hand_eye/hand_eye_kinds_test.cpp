// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// Boards, robots and lenses of other kinds: parts of a board, four axes, one to eight coefficients.

#include "calibrate/hand_eye/closed_form.h"
#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"
#include "support/board_problem.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

class HandEyeKinds : public testing::TestWithParam<bool> {
 protected:
  std::mt19937 random_{7};
};

/// Views of a board with markers, of which a corner of the picture's border cuts off a part.
HandEyeProblem partialProblem(sim::BoardCell* cell, int count, std::mt19937* random) {
  sim::giveMarkers(cell);
  HandEyeProblem problem = randomProblem(*cell, count, random);
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    Observation& view = problem.observations[i];
    const int first = static_cast<int>(i % 5), last = 4 + static_cast<int>(i % 3);
    const std::vector<Eigen::Vector2d> all = view.corners;
    view.corners.clear();
    for (std::size_t id = 0; id < all.size(); ++id) {
      const int col = static_cast<int>(id) % cell->cols;
      if (col < first || col >= first + last) continue;
      view.ids.push_back(id);
      view.corners.push_back(all[id]);
    }
  }
  return problem;
}

TEST_P(HandEyeKinds, PartsOfABoardCount) {
  sim::BoardCell cell = sim::makeCell(GetParam(), &random_);
  cell.robot_mm = 0.1;
  cell.robot_deg = 0.02;
  const HandEyeProblem problem = partialProblem(&cell, 15, &random_);
  const HandEyeResult result = solveHandEye(problem, {});
  ASSERT_EQ(result.verdict, Verdict::kGood) << result.reasons.front();
  EXPECT_EQ(result.views_used, 15);
  EXPECT_TRUE(isometryNear(result.T_mount_camera, cell.T_mount_camera, 6e-4, 0.06 * sim::kDegree));
  for (std::size_t i = 0; i < 15; ++i) {
    EXPECT_EQ(result.views[i].residuals.size(), problem.observations[i].corners.size());
  }
}

TEST_P(HandEyeKinds, WrongPartsOfABoardAreRefused) {
  sim::BoardCell cell = sim::makeCell(GetParam(), &random_);
  const HandEyeProblem problem = partialProblem(&cell, 9, &random_);
  const auto refused = [&](const auto& change, const std::vector<std::string>& words) {
    HandEyeProblem changed = problem;
    change(&changed);
    return refuses([&] { solveHandEye(changed, {}); }, words);
  };
  const auto ids = [](HandEyeProblem * p) -> auto& { return p->observations[1].ids; };
  EXPECT_TRUE(refused([&](auto* p) { ids(p)[0] = 54; }, {"view 2", "54", "up to 53"}));
  EXPECT_TRUE(refused([&](auto* p) { ids(p)[0] = ids(p)[1]; }, {"view 2", "twice"}));
  EXPECT_TRUE(refused([&](auto* p) { ids(p).pop_back(); }, {"view 2", "ids"}));
  EXPECT_TRUE(refused([](auto* p) { p->board.kind = Board::Kind::kCheckerboard; }, {"markers"}));
  EXPECT_TRUE(refused(
      [&](auto* p) {
        ids(p).resize(5);
        p->observations[1].corners.resize(5);
      },
      {"view 2", "5 corners", "fewer than 6"}));
}

/// A robot that turns about the base's z axis alone, and goes up and down.
HandEyeProblem uprightProblem(const sim::BoardCell& cell, int count, std::mt19937* random) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
  T_camera_board.translation() = Eigen::Vector3d(0.0, 0.0, 0.4) - cell.centre();
  const Eigen::Isometry3d start = cell.flangeFor(T_camera_board);
  HandEyeProblem problem = emptyProblem(cell);
  for (int i = 0; i < 4000 && static_cast<int>(problem.observations.size()) < count; ++i) {
    Eigen::Isometry3d T = start;
    T.linear() = Eigen::AngleAxisd(2.0 * any(*random), Eigen::Vector3d::UnitZ()) * start.linear();
    T.translation() +=
        Eigen::Vector3d(0.15 * any(*random), 0.15 * any(*random), 0.06 * any(*random));
    addObservation(cell, T, random, &problem);
  }
  return problem;
}

class FourAxis : public testing::TestWithParam<bool> {
 protected:
  FourAxis() {
    cell_ = sim::makeCell(GetParam(), &random_);
    cell_.robot_mm = 0.1;
    cell_.robot_deg = 0.02;
    problem_ = uprightProblem(cell_, 15, &random_);
    params_.four_axis = true;
    params_.board_z = (cell_.T_other_board * cell_.centre()).z();
    params_.board_z_sigma_mm = 0.5;
  }
  std::mt19937 random_{11};
  sim::BoardCell cell_;
  HandEyeProblem problem_;
  HandEyeParams params_;
};

TEST_P(FourAxis, IsSolvedWithTheBoardsHeight) {
  ASSERT_EQ(problem_.observations.size(), 15u);
  const HandEyeResult result = solveHandEye(problem_, params_);
  ASSERT_NE(result.verdict, Verdict::kRefused) << result.reasons.front();
  EXPECT_TRUE(isometryNear(result.T_mount_camera, cell_.T_mount_camera, 3e-3, 0.3 * sim::kDegree));
  ASSERT_FALSE(result.notes.empty());
  EXPECT_NE(result.notes.front().find("4-axis"), std::string::npos);
  EXPECT_NE(result.notes.front().find("board_z"), std::string::npos);
  // A height that is wrong by a centimetre moves the camera by that along z, and by nothing else.
  HandEyeParams wrong = params_;
  wrong.board_z += 0.01;
  const HandEyeResult higher = solveHandEye(problem_, wrong);
  const Eigen::Vector3d moved =
      higher.T_mount_camera.translation() - result.T_mount_camera.translation();
  const Eigen::Vector3d axis =
      robotSide(problem_.mounting, problem_.observations[0].T_base_flange).linear() *
      Eigen::Vector3d::UnitZ();
  EXPECT_LT((moved - 0.01 * axis).norm(), 3e-4);
  EXPECT_LT(
      rotationAngle(result.T_mount_camera.linear().transpose() * higher.T_mount_camera.linear()),
      0.01 * sim::kDegree);
  // How sure the height is goes into the camera's own.
  const Eigen::Vector3d up = result.T_mount_camera.linear().transpose() * axis;
  const double sigma = std::sqrt(up.dot(result.covariance.block<3, 3>(kHandEye, kHandEye) * up));
  EXPECT_GT(sigma, 4e-4);
  EXPECT_LT(sigma, 3e-3);
}

TEST_P(FourAxis, IsRefusedWithoutAHeightAndWithTurnsThatItCannotMake) {
  const HandEyeResult without = solveHandEye(problem_, {});
  EXPECT_EQ(without.verdict, Verdict::kRefused);
  for (const char* word : {"4-axis robot", "touch", "board_z"}) {
    EXPECT_NE(without.reasons.front().find(word), std::string::npos) << without.reasons.front();
  }
  const HandEyeResult turned = solveHandEye(randomProblem(cell_, 15, &random_), params_);
  EXPECT_EQ(turned.verdict, Verdict::kRefused);
  EXPECT_NE(turned.reasons.front().find("four_axis is set"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(BothMountings, FourAxis, testing::Bool());

/// A wide camera, and the corners as a lens with eight coefficients shows them: no polynomial does.
HandEyeProblem rationalProblem(sim::BoardCell cell, std::mt19937* random) {
  cell.camera.fx = cell.camera.fy = 1400.0;
  HandEyeProblem problem = randomProblem(cell, 20, random);
  const Camera::Model model{cell.camera.width,
                            cell.camera.height,
                            1400.0,
                            1400.0,
                            1210.0,
                            1030.0,
                            "rational_polynomial",
                            {3.0, 0.0, 0.0, 0.0, 0.0, 2.5, 0.0, 0.0}};
  const Camera camera(model);
  std::normal_distribution<double> noise(0.0, cell.corner_px);
  for (Observation& view : problem.observations) {
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      const Eigen::Vector3d p = cell.cameraBoard(view.T_base_flange) * problem.board.corner(i);
      view.corners[i] = camera.project(p) + Eigen::Vector2d(noise(*random), noise(*random));
    }
  }
  return problem;
}

TEST_P(HandEyeKinds, TheLensIsChosenByHeldOutPictures) {
  sim::BoardCell cell = sim::makeCell(GetParam(), &random_);
  const HandEyeResult five = solveHandEye(randomProblem(cell, 15, &random_), {});
  ASSERT_EQ(five.lens_trials.size(), 3u);
  EXPECT_EQ(five.lens_trials[0].coefficients, 5);
  EXPECT_TRUE(five.lens_trials[0].is_chosen);
  EXPECT_EQ(five.camera.distortion_model, "plumb_bob");
  EXPECT_GT(five.lens_trials[1].held_out_px, five.lens_trials[0].held_out_px);
  const HandEyeResult eight = solveHandEye(rationalProblem(cell, &random_), {});
  ASSERT_TRUE(eight.solved);
  EXPECT_EQ(eight.camera.distortion_model, "rational_polynomial");
  EXPECT_EQ(eight.camera.distortion.size(), 8u);
  EXPECT_LT(eight.rms_px, 0.1);
  ASSERT_FALSE(eight.notes.empty());
  EXPECT_NE(eight.notes.front().find("8 coefficients"), std::string::npos);
}

TEST_P(HandEyeKinds, ExpectedErrorsAndResidualsAreSaidInMillimetresToo) {
  sim::BoardCell cell = sim::makeCell(GetParam(), &random_);
  cell.robot_mm = 0.3;
  cell.robot_deg = 0.05;
  const HandEyeResult result = solveHandEye(randomProblem(cell, 15, &random_), {});
  ASSERT_TRUE(result.solved);
  // At least the one pose that is gone to.
  EXPECT_GT(result.with_robot_mm, std::sqrt(3.0) * result.robot_mm);
  EXPECT_GT(result.with_robot_deg, result.expected_error_deg);
  for (const ViewResult& view : result.views) {
    EXPECT_NEAR(view.rms_mm,
                view.rms_px * 1e3 * view.T_camera_board.translation().z() / result.camera.fx, 1e-9);
  }
  // A chain that is far worse than its corners is no flaw, but said.
  ASSERT_EQ(result.verdict, Verdict::kGood);
  ASSERT_FALSE(result.notes.empty());
  EXPECT_NE(result.notes.front().find("residual of the chain"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(BothMountings, HandEyeKinds, testing::Bool());

}  // namespace
}  // namespace planar_bin_picking
