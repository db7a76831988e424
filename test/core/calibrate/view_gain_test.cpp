// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "support/matchers.h"
#include "support/simulated_run.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

class UprightRun : public testing::TestWithParam<bool> {};

// A robot that turns about the vertical axis alone; of each pose that it is asked for nothing
// tilts.
TEST_P(UprightRun, KeepsARobotOfFourAxesUpright) {
  RunWorld world(GetParam(), 2);
  world.cell.robot_mm = 0.05;
  // Such a robot's flange is upright, or upside down.
  Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
  T_camera_board.translation() = Eigen::Vector3d(0.0, 0.0, 0.45) - world.cell.centre();
  world.T_base_start = world.cell.flangeFor(T_camera_board);
  const Eigen::Vector3d z = world.T_base_start.linear().col(2);
  const Eigen::Vector3d upright(0.0, 0.0, z.z() > 0.0 ? 1.0 : -1.0);
  world.T_base_start.linear() =
      Eigen::Quaterniond::FromTwoVectors(z, upright) * world.T_base_start.linear();
  HandEyeParams solver;
  solver.four_axis = true;
  solver.board_z = (world.cell.T_other_board * world.cell.centre()).z();
  solver.board_z_sigma_mm = 0.3;
  const RunOutcome outcome = world.run(wideRun(), solver);
  ASSERT_NE(outcome.result.verdict, Verdict::kRefused)
      << outcome.failure << outcome.result.reasons.front();
  ASSERT_GE(outcome.pictures, 8);
  double most_turn = 0.0;
  for (const Eigen::Isometry3d& command : outcome.commands) {
    const Eigen::Matrix3d turn = command.linear() * world.T_base_start.linear().transpose();
    EXPECT_NEAR(turn(2, 2), 1.0, 1e-6);
    most_turn = std::max(most_turn, rotationAngle(turn));
  }
  EXPECT_GT(most_turn, 20.0 * sim::kDegree);
  EXPECT_TRUE(isometryNear(outcome.result.T_mount_camera, world.cell.T_mount_camera, 4e-3,
                           0.4 * sim::kDegree));
}

INSTANTIATE_TEST_SUITE_P(BothMountings, UprightRun, testing::Bool());

}  // namespace
}  // namespace planar_bin_picking
