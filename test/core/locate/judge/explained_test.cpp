// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/explained.h"

#include "support/plates.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

/// A square from x, y with sides of 100 pixels, a point every second one; its left side confirmed
/// to `left`, the others to `others`.
ScoredPose squareAt(float x, float y, float left, float others) {
  ScoredPose out;
  for (float k = 1.0f; k < 100.0f; k += 2.0f) {
    out.outline.push_back({{x, y + k}, {-1.0f, 0.0f}, left, 1.0f});
    out.outline.push_back({{x + 100.0f, y + k}, {1.0f, 0.0f}, others, 1.0f});
    out.outline.push_back({{x + k, y}, {0.0f, -1.0f}, others, 1.0f});
    out.outline.push_back({{x + k, y + 100.0f}, {0.0f, 1.0f}, others, 1.0f});
  }
  return out;
}

/// Own score of a square whose left side is confirmed, and the others to 0.2: alone 0.4.
double ownScoreAt(float x, float y) {
  const ScoredPose better = squareAt(50, 50, 1.0f, 1.0f), pose = squareAt(x, y, 1.0f, 0.2f);
  ExplainedEdges explained({&better, &pose});
  EXPECT_NEAR(explained.ownScore(pose), 0.4, 1e-6);
  explained.add(better);
  return explained.ownScore(pose);
}

TEST(ExplainedEdges, OnlyAnEdgeFromTheOtherSideConfirmsNothing) {
  EXPECT_NEAR(ownScoreAt(152, 50), 0.2, 0.02);  // its left side is the other's right one
  EXPECT_NEAR(ownScoreAt(51, 51), 0.4, 0.01);   // the same sides
  EXPECT_NEAR(ownScoreAt(157, 50), 0.4, 1e-6);  // an edge six pixels off is another
}

/// Whether an edge at (50, 50), whose part lies to its left, explains this one; a point far off is
/// the pose's own.
bool explains(float x, float y, float normal_deg) {
  const float angle = normal_deg * static_cast<float>(kDegrees);
  ScoredPose better, pose;
  better.outline = {{{50.0f, 50.0f}, {1.0f, 0.0f}, 1.0f, 1.0f}};
  pose.outline = {{{x, y}, {std::cos(angle), std::sin(angle)}, 1.0f, 1.0f},
                  {{200.0f, 200.0f}, {1.0f, 0.0f}, 0.0f, 1.0f}};
  ExplainedEdges explained({&better, &pose});
  explained.add(better);
  return explained.ownScore(pose) < 0.25;
}

TEST(ExplainedEdges, AnEdgeIsTheSameToThreePixelsAndSomeTurn) {
  for (const float off : {-3.0f, -1.5f, 0.0f, 1.5f, 3.0f}) {
    EXPECT_TRUE(explains(50.0f + off, 50.0f, 180.0f)) << off;
    EXPECT_TRUE(explains(50.0f, 50.0f + off, 180.0f)) << off;
  }
  for (const float far : {-7.0f, 7.0f}) {
    EXPECT_FALSE(explains(50.0f + far, 50.0f, 180.0f)) << far;
    EXPECT_FALSE(explains(50.0f, 50.0f + far, 180.0f)) << far;
  }
  for (const float turn : {-60.0f, -40.0f, 40.0f, 60.0f})
    EXPECT_TRUE(explains(50.0f, 50.0f, 180.0f + turn)) << turn;
  for (const float turn : {-90.0f, -75.0f, 75.0f, 90.0f, 180.0f})
    EXPECT_FALSE(explains(50.0f, 50.0f, 180.0f + turn)) << turn;
}

TEST(ExplainedEdges, ATenthOfTheWeightIsEnoughToJudgeBy) {
  for (const float share : {0.05f, 0.15f}) {
    ScoredPose better, pose;
    pose.evidence.edges = 0.9;
    better.outline = {{{50.0f, 50.0f}, {1.0f, 0.0f}, 1.0f, 1.0f}};
    pose.outline = {{{50.0f, 50.0f}, {-1.0f, 0.0f}, 1.0f, 10.0f * (1.0f - share)},
                    {{200.0f, 200.0f}, {1.0f, 0.0f}, 0.2f, 10.0f * share}};
    ExplainedEdges explained({&better, &pose});
    explained.add(better);
    EXPECT_NEAR(explained.ownScore(pose), share < 0.1f ? 0.9 : 0.2, 1e-6);
  }
}

TEST(ExplainedEdges, PointsCountByTheirWeight) {
  ScoredPose pose = squareAt(10, 10, 1.0f, 0.0f);
  // The left side, every fourth point, as much as the three others together.
  for (std::size_t i = 0; i < pose.outline.size(); i += 4) pose.outline[i].weight = 3.0f;
  const ExplainedEdges none({&pose});
  EXPECT_NEAR(none.ownScore(pose), 0.5, 1e-6);
}

TEST(ExplainedEdges, WhereHardlyAnyPointIsLeftTheScoreStands) {
  // Four neighbours and itself in between: a tile among tiles.
  ScoredPose middle = squareAt(200, 200, 1.0f, 0.8f);
  middle.evidence.edges = 0.77;
  const ScoredPose around[] = {squareAt(100, 200, 1, 1), squareAt(300, 200, 1, 1),
                               squareAt(200, 100, 1, 1), squareAt(200, 300, 1, 1)};
  ExplainedEdges explained({&middle, &around[0], &around[1], &around[2], &around[3]});
  for (const ScoredPose& other : around) explained.add(other);
  EXPECT_EQ(explained.ownScore(middle), 0.77);
}

TEST(ExplainedEdges, OutlinesMayLeaveTheImageOrBeEmpty) {
  const ScoredPose better = squareAt(-60, -60, 1.0f, 1.0f), beside = squareAt(42, -60, 1.0f, 0.2f);
  ExplainedEdges explained({&better, &beside});
  explained.add(better);
  EXPECT_LT(explained.ownScore(beside), 0.4);
  ScoredPose empty;
  empty.evidence.edges = 0.6;
  ExplainedEdges nothing({&empty});
  nothing.add(empty);
  EXPECT_EQ(nothing.ownScore(empty), 0.6);
}

}  // namespace
}  // namespace planar_bin_picking
