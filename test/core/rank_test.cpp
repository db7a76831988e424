// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/rank.h"

#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

const Parts kParts = {makePart("bracket", bracketPlate()), makePart("wheel", wheelPlate(15, true))};

ScoredPose scoredAt(double x_mm, double score, double visible = 1.0, std::size_t part = 0) {
  ScoredPose out;
  static_cast<RefinedPose&>(out) = refinedAt(sim::poseOf({x_mm, 0, 600}), part);
  out.score = score;
  out.visible_fraction = visible;
  return out;
}

TEST(Rank, BestFirst) {
  const auto out =
      rankPoses({scoredAt(-200, 0.7), scoredAt(0, 0.9), scoredAt(200, 0.8)}, kParts, 0.5, 0, {});
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(out[0].score, 0.9);
  EXPECT_EQ(out[1].score, 0.8);
  EXPECT_EQ(out[2].score, 0.7);
  EXPECT_EQ(out[0].part_name, "bracket");
}

TEST(Rank, WhatLiesFreeGoesFirst) {
  const auto out = rankPoses({scoredAt(0, 0.9, 0.7), scoredAt(200, 0.75, 1.0)}, kParts, 0.5, 0, {});
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].visible_fraction, 1.0);
}

TEST(Rank, TheBetterOfTwoThatOverlapStays) {
  const auto out = rankPoses({scoredAt(0, 0.7), scoredAt(3, 0.8)}, kParts, 0.5, 0, {});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].score, 0.8);
}

TEST(Rank, PartsOfAnotherKindTakeThePlaceToo) {
  const auto out = rankPoses({scoredAt(0, 0.7), scoredAt(5, 0.8, 1.0, 1)}, kParts, 0.5, 0, {});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].part_name, "wheel");
}

TEST(Rank, NeighboursThatTouchBothStay) {
  EXPECT_EQ(rankPoses({scoredAt(0, 0.7), scoredAt(70, 0.8)}, kParts, 0.5, 0, {}).size(), 2u);
}

TEST(Rank, LowScoresAndSurplusAreLeftOut) {
  const std::vector<ScoredPose> poses = {scoredAt(-200, 0.49), scoredAt(0, 0.5),
                                         scoredAt(200, 0.8)};
  EXPECT_EQ(rankPoses(poses, kParts, 0.5, 0, {}).size(), 2u);
  const auto first = rankPoses(poses, kParts, 0.5, 1, {});
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].score, 0.8);
  EXPECT_TRUE(rankPoses({}, kParts, 0.5, 0, {}).empty());
}

}  // namespace
}  // namespace planar_bin_picking
