// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_run.h"
#include "support/guided_run.h"
#include "support/matchers.h"

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
    EXPECT_EQ(outcome.beyond, 0);
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

// CALIBRATION_RUNS=5000 tries ten thousand in all; see test/benchmark/calibration.md.
TEST_P(CalibrationRunTest, NothingEverLeavesItsLimits) {
  const char* const more = std::getenv("CALIBRATION_RUNS");
  const unsigned runs = more == nullptr ? 20 : static_cast<unsigned>(std::stoul(more));
  std::size_t commands = 0, cut = 0;
  for (unsigned seed = 1; seed <= runs; ++seed) {
    RunWorld world(GetParam(), 1000 + seed);
    const RunParams params = world.randomParams();
    const std::string where = "seed " + std::to_string(1000 + seed);
    try {
      const RunOutcome outcome = world.run(params, world.randomSolver());
      expectWithin(world, params.motion, outcome, where);
      commands += outcome.commands.size();
      cut += outcome.commands.size() > outcome.asked.size() ? 1 : 0;
    } catch (const std::invalid_argument&) {  // not from this start, and nothing was commanded
    }
  }
  EXPECT_GT(commands, 5 * runs);
  EXPECT_GT(cut, runs / 4);
}

TEST_P(CalibrationRunTest, LearnsWhatIsMounted) {
  RunWorld world(GetParam(), 2);
  GuidedRun guided(&world, wideRun());
  const CalibrationRun& run = guided.run;
  guided.take(4);
  EXPECT_FALSE(run.isLarge());
  EXPECT_FALSE(run.solution());
  EXPECT_EQ(run.limits().mounted().points.size(), 1u);
  EXPECT_EQ(run.limits().mounted().margin, 0.3);
  guided.take(1);
  ASSERT_TRUE(run.solution());
  guided.take(2);
  EXPECT_TRUE(run.isLarge());
  const Mounted& mounted = run.limits().mounted();
  const std::vector<Eigen::Vector3d> truth = mountedIn(world.cell);
  ASSERT_EQ(mounted.points.size(), truth.size());
  EXPECT_GT(mounted.margin, 0.03);  // clearance_m
  EXPECT_LT(mounted.margin, 0.06);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT((mounted.points[i] - truth[i]).norm(), mounted.margin - 0.03) << i;
  }
}

TEST_P(CalibrationRunTest, ContradictedRadiusEndsTheRun) {
  RunWorld world(GetParam(), 2);
  RunParams params = wideRun();
  double reach = 0.0;
  for (const Eigen::Vector3d& x : mountedIn(world.cell)) reach = std::max(reach, x.norm());
  params.motion.mounted_radius_m = reach - 0.04;
  const RunOutcome outcome = world.run(params);
  EXPECT_NE(outcome.failure.find("correct mounted_radius_m"), std::string::npos);
  EXPECT_NE(outcome.failure.find(GetParam() ? "the camera" : "the board"), std::string::npos);
  params.motion.mounted_radius_m = reach + 0.002;
  EXPECT_EQ(world.run(params).failure, "");
}

TEST_P(CalibrationRunTest, OnePlaceIsOneView) {
  RunWorld world(GetParam(), 2);
  GuidedRun guided(&world, wideRun());
  CalibrationRun& run = guided.run;
  guided.take(1);
  const auto aside = [&](double metres, double deg) {
    Vector6d xi = Vector6d::Zero();
    xi[1] = metres;
    xi[3] = deg * sim::kDegree;
    return run.problem().observations[0].T_base_flange * exp(xi);
  };
  EXPECT_TRUE(run.isKnown(aside(0.0, 0.0)));
  EXPECT_TRUE(run.isKnown(aside(4.9e-4, 0.0)));
  EXPECT_FALSE(run.isKnown(aside(5.1e-4, 0.0)));
  EXPECT_TRUE(run.isKnown(aside(0.0, 0.049)));
  EXPECT_FALSE(run.isKnown(aside(0.0, 0.051)));
  ASSERT_TRUE(guided.next());
  Observation again = run.problem().observations[0];
  run.seen(again);
  EXPECT_EQ(run.problem().observations.size(), 1u);
  EXPECT_EQ(run.poses().back().state, PlannedPose::State::kSeen);
}

TEST_P(CalibrationRunTest, AddsToAnEarlierRun) {
  RunWorld world(GetParam(), 2);
  GuidedRun first(&world, wideRun());
  first.take(8);
  EXPECT_FALSE(first.next());
  EXPECT_EQ(first.run.end(), CalibrationRun::End::kGood);
  RunParams params = wideRun();
  params.seed = 2;
  GuidedRun more(&world, params, first.run.problem().observations);
  EXPECT_TRUE(more.run.solution());
  int added = 0;
  while (more.next()) {
    added += more.visit() ? 1 : 0;
  }
  EXPECT_EQ(more.run.end(), CalibrationRun::End::kGood);
  EXPECT_EQ(more.run.problem().observations.size(), 11u);
  EXPECT_EQ(added, 4);  // the start is known already
}

TEST_P(CalibrationRunTest, SaysWhyItEnds) {
  RunWorld world(GetParam(), 2);
  HandEyeParams never;
  never.tolerance_mm = 0.001;
  RunParams params = wideRun();
  params.views_max = 6;
  EXPECT_EQ(world.run(params, never).end, CalibrationRun::End::kViews);
  params.attempts_max = 5;
  EXPECT_EQ(world.run(params, never).end, CalibrationRun::End::kAttempts);
  params = wideRun();
  EXPECT_EQ(world.run(params).end, CalibrationRun::End::kGood);
  never.tolerance_mm = 1.0;
  never.tolerance_deg = 0.001;
  EXPECT_EQ(world.run(params, never).end, CalibrationRun::End::kViews);
  params.motion.max_roll_deg = 5.0;
  params.motion.cone_deg = 5.0;  // none of the first turns is allowed
  const RunOutcome none = world.run(params);
  EXPECT_EQ(none.end, CalibrationRun::End::kNoPose);
  EXPECT_EQ(none.asked.size(), 1u);
}

TEST_P(CalibrationRunTest, TurnsLessOnceTheBoardWasLost) {
  RunWorld world(GetParam(), 2);
  GuidedRun guided(&world, wideRun());
  guided.take(1);
  const auto turn = [&] {
    EXPECT_TRUE(guided.next());
    return rotationAngle(world.T_base_start.linear().transpose() * guided.T_base_target.linear()) /
           sim::kDegree;
  };
  EXPECT_NEAR(turn(), 8.0, 1e-6);
  guided.run.lost();
  EXPECT_EQ(guided.run.poses().back().state, PlannedPose::State::kLost);
  EXPECT_NEAR(turn(), 5.6, 1e-6);
}

TEST_P(CalibrationRunTest, RefusalsCountFromTheLastMove) {
  RunWorld world(GetParam(), 2);
  GuidedRun guided(&world, wideRun());
  guided.take(1);
  CalibrationRun& run = guided.run;
  for (int i = 1; i <= 3; ++i) {
    const auto target = run.next();
    ASSERT_TRUE(target);
    ASSERT_TRUE(run.step());
    run.refused(*run.step());
    EXPECT_EQ(run.refusalsInARow(), i);
    EXPECT_EQ(run.poses().back().state, PlannedPose::State::kRefused);
  }
  ASSERT_TRUE(guided.next());
  EXPECT_EQ(run.refusalsInARow(), 0);
}

TEST_P(CalibrationRunTest, GoesOnFromWhereTheRobotStands) {
  RunWorld world(GetParam(), 2);
  RunParams params = wideRun();
  params.motion.max_step_m = 0.01;
  GuidedRun guided(&world, params);
  guided.take(1);
  CalibrationRun& run = guided.run;
  ASSERT_TRUE(run.next());
  const std::size_t planned = run.way().size();
  const Eigen::Isometry3d first = *run.step();
  // It stopped short: the next pose is too far for one step now.
  Eigen::Isometry3d short_of = first;
  short_of.translation() = world.T_base_start.translation();
  run.arrived(short_of);
  ASSERT_TRUE(run.step());
  EXPECT_LE((run.step()->translation() - short_of.translation()).norm(), 0.01 + 1e-9);
  EXPECT_GE(run.way().size(), planned - 1);
  Eigen::Isometry3d away = first;
  away.translation().x() += 5.0;
  EXPECT_TRUE(refuses([&] { run.arrived(away); }, {"went too far", "workspace"}));
}

// Of many candidates the best one is better, and the board is surely seen.
TEST_P(CalibrationRunTest, ChoosesGoodViews) {
  double many = 0.0, few = 0.0;
  int lost = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    RunParams params = wideRun();
    params.views_max = 8;
    RunWorld world(GetParam(), seed);
    const RunOutcome best = world.run(params);
    many += best.result.expected_error_mm;
    lost += best.lost;
    params.candidates = 10;
    RunWorld again(GetParam(), seed);
    few += again.run(params).result.expected_error_mm;
  }
  EXPECT_LT(many, 0.9 * few);
  EXPECT_LE(lost, 12);
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

/// After the first views of a noisy robot no large move may be sure to show the board.
TEST(CalibrationRunNoise, SmallMovesGoOnWhereLargeOnesAreTooVague) {
  RunWorld world(true, 26);
  world.cell.robot_mm = 1.0;
  world.cell.robot_deg = 0.1;
  world.unreachable = 0.1;
  world.failing = 0.02;
  RunParams params = wideRun();
  params.views_max = 8;
  const RunOutcome outcome = world.run(params);
  EXPECT_EQ(outcome.pictures, 8);
  EXPECT_NE(outcome.result.verdict, Verdict::kRefused);
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
