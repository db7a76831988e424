// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A calibration run that a test leads from pose to pose.

#include "support/simulated_run.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {

/// A run in this world, told that each pose was reached exactly and seen, up to `count` pictures.
class GuidedRun {
 public:
  GuidedRun(RunWorld* world, const RunParams& params) : GuidedRun(world, params, {}) {}
  GuidedRun(RunWorld* world, const RunParams& params, const std::vector<Observation>& earlier)
      : world_(*world), run(problemWith(*world, earlier), {}, params, world->T_base_start) {}

  /// @return  whether there was a next pose
  bool next() {
    const auto target = run.next();
    if (!target) return false;
    T_base_target = *target;
    while (const auto pose = run.step()) run.arrived(*pose);
    EXPECT_TRUE(run.isThere());
    return true;
  }
  /// @return  whether the board was seen
  bool visit() {
    HandEyeProblem one = emptyProblem(world_.cell);
    const bool is_seen = addObservation(world_.cell, T_base_target, &world_.random, &one);
    is_seen ? run.seen(one.observations[0]) : run.lost();
    return is_seen;
  }
  void take(int count) {
    while (count > 0) {
      ASSERT_TRUE(next());
      count -= visit() ? 1 : 0;
    }
  }

 private:
  static HandEyeProblem problemWith(const RunWorld& world,
                                    const std::vector<Observation>& earlier) {
    HandEyeProblem problem = emptyProblem(world.cell);
    problem.observations = earlier;
    return problem;
  }
  RunWorld& world_;

 public:
  CalibrationRun run;
  Eigen::Isometry3d T_base_target = Eigen::Isometry3d::Identity();
};

}  // namespace planar_bin_picking
