// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_run.h"
#include "support/matchers.h"
#include "support/simulated_run.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

class CalibrationRunTest : public testing::TestWithParam<bool> {};

TEST_P(CalibrationRunTest, GetsGoodByItself) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    RunWorld world(GetParam(), seed);
    const RunOutcome outcome = world.run(RunParams());
    ASSERT_EQ(outcome.result.verdict, Verdict::kGood)
        << "seed " << seed << " "
        << (outcome.result.reasons.empty() ? "" : outcome.result.reasons[0]);
    EXPECT_TRUE(isometryNear(outcome.result.T_mount_camera, world.cell.T_mount_camera, 1e-3,
                             0.1 * sim::kDegree));
    EXPECT_LE(outcome.pictures, 15);
  }
}

TEST_P(CalibrationRunTest, ReplacesRefusedPosesAndFailedMoves) {
  RunWorld world(GetParam(), 3);
  world.unreachable = 0.25;
  world.failing = 0.1;
  const RunOutcome outcome = world.run(RunParams());
  EXPECT_GT(outcome.refused, 0);
  EXPECT_EQ(outcome.result.verdict, Verdict::kGood);
}

TEST_P(CalibrationRunTest, StaysInWorkspaceAndCone) {
  RunWorld world(GetParam(), 5);
  RunParams params;
  const Eigen::Vector3d p = world.T_base_start.translation();
  params.workspace_min_x = p.x() - 0.12;
  params.workspace_max_x = p.x() + 0.12;
  params.workspace_min_y = p.y() - 0.12;
  params.workspace_max_y = p.y() + 0.12;
  params.workspace_min_z = p.z() - 0.1;
  params.workspace_max_z = p.z() + 0.1;
  params.cone_deg = 25.0;
  const RunOutcome outcome = world.run(params);
  ASSERT_GT(outcome.asked.size(), 5u);
  for (const Eigen::Isometry3d& T : outcome.asked) {
    EXPECT_LE((T.translation() - p).cwiseAbs().maxCoeff(), 0.12 + 1e-9);
    EXPECT_LE(std::abs(T.translation().z() - p.z()), 0.1 + 1e-9);
    const double cosine = T.linear().col(2).dot(world.T_base_start.linear().col(2));
    EXPECT_LE(std::acos(std::min(1.0, cosine)), 25.0 * sim::kDegree + 1e-9);
  }
}

TEST_P(CalibrationRunTest, GivesUpWhereNothingIsReachable) {
  RunWorld world(GetParam(), 6);
  world.unreachable = 1.0;
  RunParams params;
  params.attempts_max = 20;
  const RunOutcome outcome = world.run(params);
  EXPECT_LE(outcome.asked.size(), 20u);
  EXPECT_EQ(outcome.result.verdict, Verdict::kRefused);
}

INSTANTIATE_TEST_SUITE_P(BothMountings, CalibrationRunTest, testing::Bool());

TEST(CalibrationRunInput, IsChecked) {
  const RunWorld world(true, 1);
  const auto refused = [&](auto change, const std::vector<std::string>& words) {
    RunParams params;
    change(&params);
    return refuses(
        [&] { CalibrationRun run(emptyProblem(world.cell), {}, params, world.T_base_start); },
        words);
  };
  EXPECT_TRUE(refused([](auto* p) { p->cone_deg = 1.0; }, {"cone_deg", "1"}));
  EXPECT_TRUE(refused([](auto* p) { p->workspace_max_x = -3.0; }, {"workspace_max_x", "empty"}));
  EXPECT_TRUE(refused([](auto* p) { p->workspace_max_z = -1.0; }, {"outside the workspace"}));
}

}  // namespace
}  // namespace planar_bin_picking
