// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
/// What a robot refused once is not asked for again.
#include "support/simulated_run.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

/// Refuses one pose of a run that would be good by itself, and goes on.
struct Refusal {
  explicit Refusal(unsigned seed, double share) {
    RunWorld world(true, seed);
    CalibrationRun run(emptyProblem(world.cell), {}, wideRun(), world.T_base_start);
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    while (const auto target = run.next()) {
      std::optional<Eigen::Isometry3d> no;
      // The first, small moves lie next to each other.
      if (run.isLarge()) check(*target, 0.03, 6.0);
      while (const auto pose = run.step()) {
        check(*pose, 0.005, 1.0);
        if (chance(world.random) < share) no = pose;
        if (no) break;
        run.arrived(*pose);
      }
      HandEyeProblem one = emptyProblem(world.cell);
      if (no) {
        refused.push_back(*no);
        run.refused(*no);
      } else if (addObservation(world.cell, *target, &world.random, &one)) {
        run.seen(one.observations[0]);
      } else {
        run.lost();
      }
    }
    pictures = run.problem().observations.size();
  }

  void check(const Eigen::Isometry3d& pose, double metres, double deg) {
    for (const Eigen::Isometry3d& other : refused) {
      const Eigen::Isometry3d between = other.inverse() * pose;
      const bool is_near = between.translation().norm() < metres &&
                           rotationAngle(between.linear()) < deg * sim::kDegree;
      again += is_near ? 1 : 0;
    }
  }

  std::vector<Eigen::Isometry3d> refused;
  int again = 0;
  std::size_t pictures = 0;
};

TEST(CalibrationRefusal, IsNotAskedForAgain) {
  std::size_t refusals = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Refusal run(seed, 0.15);
    refusals += run.refused.size();
    EXPECT_GE(run.pictures, 8u) << seed;
    EXPECT_EQ(run.again, 0) << seed;
  }
  EXPECT_GT(refusals, 10u);
}

// Each axis both ways, then two and three at once: whatever a robot refuses, others are left.
TEST(CalibrationRefusal, FirstMovesTurnAllWays) {
  RunWorld world(true, 2);
  RunParams params = wideRun();
  params.refusals_max = 100;
  CalibrationRun run(emptyProblem(world.cell), {}, params, world.T_base_start);
  Eigen::Matrix3Xd turns(3, 14);
  for (int i = -1; i < 14; ++i) {
    const auto target = run.next();
    ASSERT_TRUE(target);
    const Eigen::Isometry3d off = world.T_base_start.inverse() * *target;
    if (i >= 0) turns.col(i) = rotationVector(off.linear()) / (8.0 * sim::kDegree);
    EXPECT_LT(off.translation().norm(), 0.04);
    run.refused(world.T_base_start * exp(Vector6d::Constant(1.0)));  // elsewhere
  }
  const auto isNear = [&](int at, double x, double y, double z) {
    return (turns.col(at) - Eigen::Vector3d(x, y, z)).norm() < 1e-6;
  };
  EXPECT_TRUE(isNear(0, 1, 0, 0) && isNear(1, 0, 1, 0) && isNear(2, 0, 0, 2));
  EXPECT_LT((turns.leftCols(3) + turns.middleCols(3, 3)).norm(), 1e-6);
  EXPECT_TRUE(isNear(6, 1, 1, 1) && isNear(7, -1, 1, 1));
  EXPECT_TRUE(isNear(8, 1, -1, 1) && isNear(9, -1, -1, 1));
  EXPECT_TRUE(isNear(10, 1, 0, 2) && isNear(11, -1, 0, -2));
  EXPECT_TRUE(isNear(12, 0, 1, 2) && isNear(13, 0, -1, -2));
}

}  // namespace
}  // namespace planar_bin_picking
