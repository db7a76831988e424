// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// The benchmark's mistakes with a few seeds each; test/benchmark/calibration.md has them with many.
#include "benchmark/calibration_refusals.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

TEST(Mistakes, AreRefusedAndNamed) {
  for (const Mistake& mistake : mistakes()) {
    for (unsigned seed = 1; seed <= 2; ++seed) {
      std::mt19937 random(seed);
      sim::BoardCell cell = sim::makeCell(seed % 2 == 0, &random);
      cell.robot_mm = 0.1;
      cell.robot_deg = 0.02;
      const HandEyeResult result = solveHandEye(mistake.make(cell, &random), {});
      EXPECT_EQ(result.verdict, Verdict::kRefused) << mistake.name;
      ASSERT_FALSE(result.reasons.empty()) << mistake.name;
      EXPECT_NE(result.reasons[0].find(mistake.word), std::string::npos)
          << mistake.name << ": " << result.reasons[0];
    }
  }
}

// What explains all the rest is the only reason: consequences would send people astray.
TEST(Mistakes, StandAlone) {
  for (const Mistake& mistake : mistakes()) {
    if (mistake.name != std::string("millimetres for metres")) continue;
    std::mt19937 random(5);
    const sim::BoardCell cell = sim::makeCell(true, &random);
    EXPECT_EQ(solveHandEye(mistake.make(cell, &random), {}).reasons.size(), 1u);
  }
}

TEST(Mistakes, AreNotSeenWhereThereAreNone) {
  std::mt19937 random(6);
  sim::BoardCell cell = sim::makeCell(true, &random);
  const HandEyeProblem small = withSquare(randomProblem(cell, 14, &random), 0.5);
  const HandEyeResult result = solveHandEye(small, {});
  ASSERT_EQ(result.verdict, Verdict::kRefused);
  EXPECT_EQ(result.reasons[0].find("square size wrong"), 0u) << result.reasons[0];
  cell.robot_mm = 10.0;
  cell.robot_deg = 0.8;
  EXPECT_EQ(solveHandEye(randomProblem(cell, 20, &random), {}).reasons.at(0).find("robot noise"),
            0u);
}

TEST(Mistakes, TwoAtOnceAreRefused) {
  std::mt19937 random(41);
  const sim::BoardCell cell = sim::makeCell(true, &random);
  const HandEyeProblem good = randomProblem(cell, 14, &random);
  const auto metres = [](Eigen::Isometry3d T) {
    T.translation() *= 1000.0;
    return T;
  };
  const auto inverted = [](const Eigen::Isometry3d& T) { return T.inverse(); };
  for (const HandEyeProblem& problem :
       {withPoses(withOrientations(good, Orientation::kRealPartFirst), metres),
        withPoses(withPoses(good, metres), inverted), withPoses(withSquare(good, 2.0), inverted),
        stale(withSquare(good, 1.05), 1, 100)}) {
    EXPECT_EQ(solveHandEye(problem, {}).verdict, Verdict::kRefused);
  }
}

// These two cancel out in all pictures: only the lengths tell.
TEST(Mistakes, InvertedPosesWithTheOtherMountingAreDoubted) {
  for (const bool in_hand : {true, false}) {
    std::mt19937 random(42);
    const sim::BoardCell cell = sim::makeCell(in_hand, &random);
    const HandEyeProblem good = randomProblem(cell, 14, &random);
    EXPECT_TRUE(solveHandEye(good, {}).notes.empty());
    HandEyeProblem both = withPoses(good, [](const Eigen::Isometry3d& T) { return T.inverse(); });
    both.mounting = in_hand ? Mounting::kEyeToHand : Mounting::kEyeInHand;
    const HandEyeResult result = solveHandEye(both, {});
    ASSERT_EQ(result.notes.size(), 1u);
    EXPECT_NE(result.notes[0].find("check the mounting"), std::string::npos) << result.notes[0];
  }
}

// The pictures stay the same while the robot says that it goes elsewhere.
TEST(Mistakes, OldPicturesAreNamed) {
  std::mt19937 random(7);
  const sim::BoardCell cell = sim::makeCell(true, &random);
  HandEyeProblem problem = randomProblem(cell, 14, &random);
  for (std::size_t i = 5; i < 14; ++i) {
    problem.observations[i].corners = problem.observations[4].corners;
  }
  const HandEyeResult result = solveHandEye(problem, {});
  EXPECT_EQ(result.verdict, Verdict::kRefused);
  EXPECT_EQ(result.reasons.at(0).find("the pictures are old"), 0u) << result.reasons[0];
}

TEST(RepeatedViews, CountOnce) {
  std::mt19937 random(8);
  const sim::BoardCell cell = sim::makeCell(false, &random);
  const HandEyeProblem problem = repeated(cell, 9, 2, &random);
  const HandEyeResult result = solveHandEye(problem, {});
  EXPECT_EQ(result.views_used, 9);
  EXPECT_EQ(result.views[9].why_not, "the same view as view 1");
  EXPECT_FALSE(result.views[9].used);
}

}  // namespace
}  // namespace planar_bin_picking
