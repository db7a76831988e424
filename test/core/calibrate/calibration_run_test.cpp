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
    const RunOutcome outcome = world.run(wideRun());
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
  const RunOutcome outcome = world.run(wideRun());
  EXPECT_GT(outcome.refused, 0);
  EXPECT_EQ(outcome.result.verdict, Verdict::kGood);
}

/// Where a robot drives that goes straight and turns about one fixed axis from pose to pose.
template <class Look>
void alongPath(const RunOutcome& outcome, const Look& look) {
  for (std::size_t k = 0; k < outcome.commands.size(); ++k) {
    const Eigen::Isometry3d &from = outcome.stood[k], &to = outcome.commands[k];
    const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
    constexpr int kLooks = 40;
    for (int i = 0; i <= kLooks; ++i) {
      const double share = static_cast<double>(i) / kLooks;
      Eigen::Isometry3d T = from;
      T.translation() += share * (to.translation() - from.translation());
      T.rotate(Eigen::AngleAxisd(share * turn.angle(), turn.axis()));
      look(T);
    }
  }
}

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / sim::kDegree;
}

/// The turn about z of what is left once the z axis has been brought to the other's the short way.
double rollBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::Quaterniond tilt =
      Eigen::Quaterniond::FromTwoVectors(a.linear().col(2), b.linear().col(2));
  const Eigen::Matrix3d R = (tilt * a.linear()).transpose() * b.linear();
  return std::atan2(R(1, 0), R(0, 0)) / sim::kDegree;
}

/// The camera, or the board's corners, as they really are on the flange.
std::vector<Eigen::Vector3d> mountedIn(const sim::BoardCell& cell) {
  if (cell.in_hand) return {cell.T_mount_camera.translation()};
  std::vector<Eigen::Vector3d> corners;
  for (const int col : {-1, cell.cols}) {
    for (const int row : {-1, cell.rows})
      corners.push_back(cell.T_other_board * cell.corner(col, row));
  }
  return corners;
}

/// How far, metres, the point is outside of box and planes; negative within.
double outside(const MotionParams& p, const Eigen::Vector3d& x) {
  double most = -1e9;
  const double lows[] = {p.workspace_min_x, p.workspace_min_y, p.workspace_min_z};
  const double highs[] = {p.workspace_max_x, p.workspace_max_y, p.workspace_max_z};
  for (int i = 0; i < 3; ++i) most = std::max({most, lows[i] - x[i], x[i] - highs[i]});
  for (std::size_t i = 0; i + 3 < p.planes.size(); i += 4) {
    const Eigen::Vector3d n(p.planes[i], p.planes[i + 1], p.planes[i + 2]);
    most = std::max(most, p.planes[i + 3] - n.dot(x));
  }
  return most;
}

void expectWithin(const RunWorld& world, const MotionParams& params, const RunOutcome& outcome,
                  const std::string& where) {
  const Eigen::Isometry3d& start = world.T_base_start;
  for (std::size_t k = 0; k < outcome.commands.size(); ++k) {
    const Eigen::Isometry3d step = outcome.stood[k].inverse() * outcome.commands[k];
    EXPECT_LE(step.translation().norm(), params.max_step_m + 1e-9) << where;
    EXPECT_LE(rotationAngle(step.linear()), params.max_turn_deg * sim::kDegree + 1e-6) << where;
  }
  double out = -1e9, cone = 0.0, roll = 0.0;
  const std::vector<Eigen::Vector3d> mounted = mountedIn(world.cell);
  alongPath(outcome, [&](const Eigen::Isometry3d& T) {
    out = std::max(out, outside(params, T.translation()));
    for (const Eigen::Vector3d& point : mounted) out = std::max(out, outside(params, T * point));
    cone = std::max(cone, angleBetween(T.linear().col(2), start.linear().col(2)));
    roll = std::max(roll, std::abs(rollBetween(start, T)));
  });
  EXPECT_LE(out, 1e-6) << where;
  EXPECT_LE(cone, params.cone_deg + 1e-6) << where;
  EXPECT_LE(roll, params.max_roll_deg + 1e-6) << where;
}

TEST_P(CalibrationRunTest, StaysInWorkspaceAndCone) {
  RunWorld world(GetParam(), 5);
  RunParams params = wideRun();
  MotionParams& motion = params.motion;
  const Eigen::Vector3d p = world.T_base_start.translation();
  motion.workspace_min_x = p.x() - 0.4;
  motion.workspace_max_x = p.x() + 0.4;
  motion.workspace_min_y = p.y() - 0.4;
  motion.workspace_max_y = p.y() + 0.4;
  motion.workspace_min_z = p.z() - 0.4;
  motion.planes = {0.0, 0.0, -1.0, -p.z() - 0.38};
  motion.cone_deg = 25.0;
  motion.max_roll_deg = 40.0;
  const RunOutcome outcome = world.run(params);
  ASSERT_GT(outcome.asked.size(), 7u);
  ASSERT_EQ(outcome.failure, "");
  expectWithin(world, motion, outcome, "");
  // There and back, in small steps.
  EXPECT_GT(outcome.commands.size(), outcome.asked.size());
  EXPECT_TRUE(isometryNear(outcome.commands.back(), world.T_base_start, 1e-9, 1e-9));
}

TEST_P(CalibrationRunTest, NothingEverLeavesItsLimits) {
  const char* const more = std::getenv("CALIBRATION_RUNS");
  const unsigned runs = more == nullptr ? 60 : static_cast<unsigned>(std::stoul(more));
  std::size_t commands = 0, cut = 0;
  for (unsigned seed = 1; seed <= runs; ++seed) {
    RunWorld world(GetParam(), 1000 + seed);
    const RunParams params = world.randomParams();
    const std::string where = "seed " + std::to_string(1000 + seed);
    try {
      const RunOutcome outcome = world.run(params);
      expectWithin(world, params.motion, outcome, where);
      commands += outcome.commands.size();
      cut += outcome.commands.size() > outcome.asked.size() ? 1 : 0;
    } catch (const std::invalid_argument&) {  // not from this start, and nothing was commanded
    }
  }
  EXPECT_GT(commands, 5 * runs);
  EXPECT_GT(cut, runs / 4);
}

TEST_P(CalibrationRunTest, GivesUpWhereNothingIsReachable) {
  RunWorld world(GetParam(), 6);
  world.unreachable = 1.0;
  RunParams params = wideRun();
  params.attempts_max = 20;
  const RunOutcome outcome = world.run(params);
  EXPECT_LE(outcome.asked.size(), 20u);
  EXPECT_EQ(outcome.result.verdict, Verdict::kRefused);
}

INSTANTIATE_TEST_SUITE_P(BothMountings, CalibrationRunTest, testing::Bool());

TEST(CalibrationRunInput, IsChecked) {
  const RunWorld world(true, 1);
  const auto refused = [&](auto change, const std::vector<std::string>& words) {
    RunParams params = wideRun();
    change(&params);
    return refuses(
        [&] { CalibrationRun run(emptyProblem(world.cell), {}, params, world.T_base_start); },
        words);
  };
  EXPECT_TRUE(refused([](auto* p) { p->motion.cone_deg = 1.0; }, {"cone_deg", "1"}));
  EXPECT_TRUE(
      refused([](auto* p) { p->motion.workspace_max_x = -3.0; }, {"workspace_max_x", "empty"}));
  EXPECT_TRUE(
      refused([](auto* p) { p->motion.workspace_max_z = -1.0; }, {"outside the workspace"}));
}

}  // namespace
}  // namespace planar_bin_picking
