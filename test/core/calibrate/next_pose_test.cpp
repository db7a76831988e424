// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// What decides about the next pose of a calibration run, to the number.

#include "planar_bin_picking/calibrate/calibration_run.h"
#include "support/guided_run.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

Eigen::Isometry3d moved(const Eigen::Isometry3d& T, double metres, double deg) {
  Vector6d xi = Vector6d::Zero();
  xi[0] = metres;
  return T * exp(xi) *
         rigid(Eigen::AngleAxisd(deg * sim::kDegree, Eigen::Vector3d::UnitY()).toRotationMatrix(),
               Eigen::Vector3d::Zero());
}

class NextPoseTest : public testing::TestWithParam<bool> {
 protected:
  NextPoseTest() : world_(GetParam(), 2) {}

  /// Whether the run still goes to the same place after the robot refused this pose.
  static bool goesThereAfterRefusal(const CalibrationRun& run, const Eigen::Isometry3d& there,
                                    const Eigen::Isometry3d& refused) {
    CalibrationRun copy = run;
    copy.refused(refused);
    const auto next = copy.next();
    return next && next->isApprox(there, 1e-12);
  }

  RunWorld world_;
};

// The table is the code's; a turn that is left out or doubled leaves an axis unseen.
TEST_P(NextPoseTest, FirstMovesTurnAboutAllAxes) {
  RunParams params = wideRun();
  params.attempts_max = 100;
  GuidedRun guided(&world_, params);
  guided.take(1);
  const Observation start = guided.run.problem().observations[0];
  std::vector<Eigen::Vector3d> turns;
  double shift = 0.0;
  while (guided.next()) {
    const Eigen::Isometry3d T = world_.T_base_start.inverse() * guided.T_base_target;
    turns.push_back(rotationVector(T.linear()) / (8.0 * sim::kDegree));
    shift = std::max(shift, log(T).head<3>().cwiseAbs().maxCoeff());
    guided.run.seen(start);  // counts once: nothing is learnt
  }
  EXPECT_EQ(guided.run.end(), CalibrationRun::End::kNoPose);
  const std::vector<Eigen::Vector3d> expected{
      {1, 0, 0},  {0, 1, 0},  {0, 0, 2},   {-1, 0, 0}, {0, -1, 0},  {0, 0, -2}, {1, 1, 1},
      {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1}, {1, 0, 2},  {-1, 0, -2}, {0, 1, 2},  {0, -1, -2}};
  ASSERT_EQ(turns.size(), 3 * expected.size());
  for (std::size_t i = 0; i < turns.size(); ++i) {
    EXPECT_LT((turns[i] - expected[i % expected.size()]).norm(), 1e-6) << i;
  }
  EXPECT_LE(shift, 0.02);
  EXPECT_GT(shift, 0.015);
}

TEST_P(NextPoseTest, NothingNearARefusedPoseIsTried) {
  GuidedRun guided(&world_, wideRun());
  guided.take(6);
  CalibrationRun copy = guided.run;
  const auto there = copy.next();
  ASSERT_TRUE(there);
  EXPECT_FALSE(goesThereAfterRefusal(guided.run, *there, *there));
  EXPECT_FALSE(goesThereAfterRefusal(guided.run, *there, moved(*there, 0.029, 0.0)));
  EXPECT_TRUE(goesThereAfterRefusal(guided.run, *there, moved(*there, 0.031, 0.0)));
  EXPECT_FALSE(goesThereAfterRefusal(guided.run, *there, moved(*there, 0.0, 5.9)));
  EXPECT_TRUE(goesThereAfterRefusal(guided.run, *there, moved(*there, 0.0, 6.1)));
}

TEST_P(NextPoseTest, NoWayLeadsThroughARefusedPose) {
  RunParams params = wideRun();
  params.motion.max_turn_deg = 7.0;
  GuidedRun guided(&world_, params);
  guided.take(6);
  CalibrationRun copy = guided.run;
  const auto there = copy.next();
  ASSERT_TRUE(there);
  ASSERT_GT(copy.way().size(), 2u);
  const Eigen::Isometry3d through = copy.way().front();
  // It is not the place itself that is too near.
  const Eigen::Isometry3d apart = through.inverse() * *there;
  ASSERT_TRUE(apart.translation().norm() > 0.036 ||
              rotationAngle(apart.linear()) > 7.0 * sim::kDegree);
  EXPECT_FALSE(goesThereAfterRefusal(guided.run, *there, through));
  EXPECT_FALSE(goesThereAfterRefusal(guided.run, *there, moved(through, 0.0049, 0.0)));
  EXPECT_TRUE(goesThereAfterRefusal(guided.run, *there, moved(through, 0.0051, 0.0)));
  EXPECT_FALSE(goesThereAfterRefusal(guided.run, *there, moved(through, 0.0, 0.9)));
  EXPECT_TRUE(goesThereAfterRefusal(guided.run, *there, moved(through, 0.0, 1.1)));
}

// Every loss counts a third of the doubt more, so that the board is kept further from the border.
TEST_P(NextPoseTest, IsMoreCautiousOnceTheBoardWasLost) {
  GuidedRun guided(&world_, wideRun());
  guided.take(5);
  const auto margin = [&](int losses) {
    CalibrationRun run = guided.run;
    for (int i = 0; i < losses; ++i) run.lost();
    const auto there = run.next();
    if (!there) return 1e9;
    HandEyeProblem one = emptyProblem(world_.cell);
    std::mt19937 random(1);
    if (!addObservation(world_.cell, *there, &random, &one)) return -1e9;
    double least = 1e9;
    for (const Eigen::Vector2d& p : one.observations[0].corners) {
      least = std::min({least, p.x(), p.y(), one.width - 1 - p.x(), one.height - 1 - p.y()});
    }
    return least;
  };
  EXPECT_GT(margin(12), margin(0));
}

INSTANTIATE_TEST_SUITE_P(BothMountings, NextPoseTest, testing::Bool());

}  // namespace
}  // namespace planar_bin_picking
