// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/chain.h"
#include "planar_bin_picking/image/camera.h"
#include "support/board_problem.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

Chain trueChain(const sim::BoardCell& cell) {
  Chain chain;
  chain.mounting = cell.in_hand ? Mounting::kEyeInHand : Mounting::kEyeToHand;
  const sim::PinholeCamera& c = cell.camera;
  chain.intrinsics = {c.fx,      c.fy,      c.cx,      c.cy,     c.lens[0],
                      c.lens[1], c.lens[2], c.lens[3], c.lens[4]};
  chain.T_mount_camera = cell.T_mount_camera;
  chain.T_other_board = cell.T_other_board;
  return chain;
}

class HandEyeModel : public testing::TestWithParam<bool> {
 protected:
  HandEyeModel() {
    cell_.corner_px = 0.0;
    const HandEyeProblem problem = randomProblem(cell_, 1, &random_);
    observation_ = problem.observations[0];
    board_ = problem.board;
  }
  std::mt19937 random_{3};
  sim::BoardCell cell_ = sim::makeCell(GetParam(), &random_);
  Observation observation_;
  Board board_;
};

TEST_P(HandEyeModel, PredictsWhatTheCellShows) {
  const auto prediction =
      predict(trueChain(cell_), observation_.T_base_flange, {}, board_.points(), false);
  ASSERT_TRUE(prediction);
  for (std::size_t i = 0; i < board_.size(); ++i) {
    const Eigen::Vector2d p = prediction->pixels.segment<2>(2 * static_cast<Eigen::Index>(i));
    EXPECT_LT((p - observation_.corners[i]).norm(), 1e-8);
  }
}

TEST_P(HandEyeModel, PredictsWhatARationalCameraShows) {
  Chain chain = trueChain(cell_);
  chain.intrinsics[9] = 0.2, chain.intrinsics[10] = -0.1, chain.intrinsics[11] = 0.05;
  const Camera camera(toModel(chain.intrinsics, cell_.camera.width, cell_.camera.height));
  ASSERT_EQ(camera.model().distortion_model, "rational_polynomial");
  EXPECT_EQ(fromModel(camera.model()), chain.intrinsics);
  const auto prediction = predict(chain, observation_.T_base_flange, {}, board_.points(), false);
  ASSERT_TRUE(prediction);
  const Eigen::Isometry3d T_camera_board = chain.cameraBoard(observation_.T_base_flange);
  for (std::size_t i = 0; i < board_.size(); ++i) {
    const Eigen::Vector2d p = prediction->pixels.segment<2>(2 * static_cast<Eigen::Index>(i));
    EXPECT_LT((p - camera.project(T_camera_board * board_.corner(i))).norm(), 1e-8);
  }
}

TEST_P(HandEyeModel, JacobiansEqualDifferences) {
  using Point = Eigen::Matrix<double, kColumns + 6, 1>;
  Chain chain = trueChain(cell_);
  chain.intrinsics[9] = 0.2, chain.intrinsics[10] = -0.1, chain.intrinsics[11] = 0.05;
  Point at = Point::Zero();
  for (int i = 0; i < kHandEye; ++i) at[i] = chain.intrinsics[static_cast<std::size_t>(i)];
  // Away from zero, since the solver asks there, too.
  at.segment<6>(kHandEye) << 0.01, -0.02, 0.005, 0.02, 0.01, -0.03;
  at.segment<6>(kBoard) << -0.01, 0.01, 0.02, -0.01, 0.02, 0.01;
  at[kScale] = 0.05;
  at.tail<6>() << 0.002, 0.001, -0.003, 0.004, -0.002, 0.001;
  const auto full = [&](const Point& x, bool jacobians) {
    Chain moved_chain = chain;
    for (int i = 0; i < kHandEye; ++i) moved_chain.intrinsics[static_cast<std::size_t>(i)] = x[i];
    const Increment increment{x.segment<6>(kHandEye), x.segment<6>(kBoard), x.tail<6>(), x[kScale]};
    return *predict(moved_chain, observation_.T_base_flange, increment, board_.points(), jacobians);
  };
  const Prediction prediction = full(at, true);
  EXPECT_LT((prediction.pixels - full(at, false).pixels).norm(), 1e-9);
  for (int i = 0; i < kColumns + 6; ++i) {
    const double step = 1e-6 * std::max(1.0, std::abs(at[i]));
    const Point delta = step * Point::Unit(i);
    const Eigen::VectorXd numeric =
        (full(at + delta, false).pixels - full(at - delta, false).pixels) / (2.0 * step);
    const Eigen::VectorXd analytic = i < kColumns
                                         ? Eigen::VectorXd(prediction.shared.col(i))
                                         : Eigen::VectorXd(prediction.correction.col(i - kColumns));
    // Differences of thousands of pixels over 2e-6: good to 1e-6 relative.
    EXPECT_LT((numeric - analytic).norm(), 1e-5 * (1.0 + analytic.norm())) << "column " << i;
  }
}

TEST_P(HandEyeModel, HasNoImageOfWhatIsBehind) {
  Chain chain = trueChain(cell_);
  chain.T_mount_camera = chain.T_mount_camera * Eigen::AngleAxisd(3.14, Eigen::Vector3d::UnitX());
  EXPECT_FALSE(predict(chain, observation_.T_base_flange, {}, board_.points(), true));
}

INSTANTIATE_TEST_SUITE_P(BothMountings, HandEyeModel, testing::Bool());

}  // namespace
}  // namespace planar_bin_picking
