// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/rank.h"

#include "support/stages.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace planar_bin_picking {
namespace {

const Parts kParts = {makePart("bracket", bracketPlate()), makePart("wheel", wheelPlate(15, true))};

ScoredPose scoredAt(double x_mm, double score, double visible = 1.0, std::size_t part = 0) {
  ScoredPose out;
  static_cast<RefinedPose&>(out) = refinedAt(sim::poseOf({x_mm, 0, 600}), part);
  out.score = score;
  out.evidence.edges = score;
  out.visible_fraction = visible;
  return out;
}

TEST(Rank, BestFirst) {
  const auto out =
      rankPoses({scoredAt(-200, 0.7), scoredAt(0, 0.9), scoredAt(200, 0.8)}, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(out[0].score, 0.9);
  EXPECT_EQ(out[1].score, 0.8);
  EXPECT_EQ(out[2].score, 0.7);
  EXPECT_EQ(out[0].part_name, "bracket");
}

TEST(Rank, WhatLiesFreeGoesFirst) {
  const auto out = rankPoses({scoredAt(0, 0.9, 0.7), scoredAt(200, 0.75, 1.0)}, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].visible_fraction, 1.0);
}

TEST(Rank, TheBetterOfTwoThatOverlapStays) {
  const auto out = rankPoses({scoredAt(0, 0.7), scoredAt(3, 0.8)}, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].score, 0.8);
}

TEST(Rank, PartsOfAnotherKindTakeThePlaceToo) {
  const auto out = rankPoses({scoredAt(0, 0.7), scoredAt(5, 0.8, 1.0, 1)}, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].part_name, "wheel");
}

TEST(Rank, NeighboursThatTouchBothStay) {
  EXPECT_EQ(rankPoses({scoredAt(0, 0.7), scoredAt(70, 0.8)}, kParts, 0.5, {}).size(), 2u);
}

/// Most probabilities are near 1.
TEST(Rank, TheBetterConfirmedFirst) {
  ScoredPose less = scoredAt(-200, 0.98), more = scoredAt(200, 0.97);
  less.evidence.edges = 0.85;
  more.evidence.edges = 0.95;
  const auto out = rankPoses({less, more}, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].score, 0.97);
}

/// Even odds of two tilts, 8.5 degrees apart: one standard deviation is 6.
TEST(Rank, TheSurerTiltFirst) {
  ScoredPose open = scoredAt(-200, 0.97), sure = scoredAt(200, 0.96);
  open.evidence.edges = 0.95, sure.evidence.edges = 0.85;
  open.covariance(3, 3) = std::pow(6.0 * M_PI / 180.0, 2);
  const auto out = rankPoses({open, sure}, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].score, 0.96);
  EXPECT_EQ(out[0].evidence.edges, 0.85);
  EXPECT_NEAR(out[1].evidence.edges, 0.6827 * 0.95, 1e-4);
}

/// At one place the better confirmed one: the other may be wrong of its tilt and sure.
TEST(Rank, ASureTiltTakesNoPlace) {
  ScoredPose open = scoredAt(0, 0.97), sure = scoredAt(2, 0.96);
  open.evidence.edges = 0.95, sure.evidence.edges = 0.85;
  open.covariance(3, 3) = std::pow(6.0 * M_PI / 180.0, 2);
  const auto out = rankPoses({open, sure}, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].score, 0.97);
}

TEST(Rank, APrintThatIsSeenIsEvidenceAgainstWhatHasNone) {
  sim::Plate plain = printedPlate();
  plain.prints.clear();
  const Parts parts = {makePart("printed", printedPlate()), makePart("plain", plain)};
  const auto firstOf = [&](double print, double x_mm) {
    ScoredPose printed = scoredAt(0, 0.75);
    printed.print = print;
    return rankPoses({printed, scoredAt(x_mm, 0.85, 1.0, 1)}, parts, 0.5, {}).front().part_name;
  };
  EXPECT_EQ(firstOf(0.9, 2), "printed");
  EXPECT_EQ(firstOf(0.3, 2), "plain");   // by chance
  EXPECT_EQ(firstOf(0.9, 70), "plain");  // lies elsewhere
}

/// A pose whose edges are those of a better one's other side: combs in the gaps of combs.
TEST(Rank, WhatABetterOneExplainsConfirmsNothing) {
  ScoredPose better = scoredAt(-100, 0.9), other = scoredAt(100, 0.7, 0.6);
  for (float y = 0.0f; y < 200.0f; y += 2.0f) {
    better.outline.push_back({{100.0f, y}, {1.0f, 0.0f}, 1.0f, 1.0f});
    other.outline.push_back({{100.0f, y}, {-1.0f, 0.0f}, 1.0f, 1.0f});  // the same edge
    other.outline.push_back({{200.0f, y}, {1.0f, 0.0f}, 0.25f, 0.5f});  // its own
  }
  EXPECT_EQ(rankPoses({better, other}, kParts, 0.5, {}).size(), 1u);
  for (OutlineEvidence& point : other.outline) point.inlier = std::max(point.inlier, 0.35f);
  EXPECT_EQ(rankPoses({better, other}, kParts, 0.5, {}).size(), 2u);
}

TEST(Rank, LowScoresAreLeftOut) {
  const std::vector<ScoredPose> poses = {scoredAt(-200, 0.49), scoredAt(0, 0.5),
                                         scoredAt(200, 0.8)};
  const auto out = rankPoses(poses, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].score, 0.8);
  EXPECT_EQ(out[1].score, 0.5);
  EXPECT_TRUE(rankPoses({}, kParts, 0.5, {}).empty());
}

TEST(Rank, WhatIsCoveredLosesMoreThanItsShare) {
  // 0.9 of it seen weighs 0.81: less than a score of 0.82, though more than one of 0.80.
  for (const double other : {0.80, 0.82}) {
    const auto out = rankPoses({scoredAt(-100, other), scoredAt(100, 1.0, 0.9)}, kParts, 0.5, {});
    ASSERT_EQ(out.size(), 2u);
    EXPECT_EQ(out[0].score, other > 0.81 ? other : 1.0);
  }
}

TEST(Rank, OfEqualOnesTheFirstStaysFirst) {
  const auto out =
      rankPoses({scoredAt(-100, 0.8), scoredAt(100, 0.8), scoredAt(0, 0.8)}, kParts, 0.5, {});
  ASSERT_EQ(out.size(), 3u);
  EXPECT_LT(out[0].T_camera_part.translation().x(), -0.09);
  EXPECT_GT(out[1].T_camera_part.translation().x(), 0.09);
}

/// Two rectangles of 100 x 40 mm, `off_mm` apart along the longer side: they share 1 - off / 100 of
/// their area.
std::size_t leftOfTwo(double off_mm, double overlap_max, double z_mm = 600.0,
                      double turn_deg = 0.0) {
  sim::Plate plate;
  plate.outer = rectangle(0, 0, 100, 40);
  plate.holes = {{{10, 10}, {10, 30}, {60, 30}, {60, 10}}};  // counts as area, too
  const Parts parts = {makePart("plate", plate)};
  const Eigen::Isometry3d T_turn(Eigen::AngleAxisd(turn_deg * kDegrees, Eigen::Vector3d::UnitZ()));
  std::vector<ScoredPose> poses(2);
  for (int i = 0; i < 2; ++i) {
    static_cast<RefinedPose&>(poses[i]) =
        refinedAt(T_turn * sim::poseOf({i * off_mm - 50, -20, z_mm}));
    poses[i].score = 0.8 + 0.1 * i;
    poses[i].evidence.edges = poses[i].score;
    poses[i].visible_fraction = 1.0;
  }
  RankParams params;
  params.overlap_max = overlap_max;
  return rankPoses(poses, parts, 0.5, params).size();
}

TEST(Rank, TheShareOfTheAreaDecides) {
  // The grid has 16 cells along the plate: a share is known to one of them, 0.06.
  for (const double turn : {0.0, 90.0, 30.0}) {
    for (const double share : {0.2, 0.5, 0.8}) {
      const double off = 100.0 * (1.0 - share);
      EXPECT_EQ(leftOfTwo(off - 10.0, share, 600.0, turn), 1u) << share << " " << turn;
      EXPECT_EQ(leftOfTwo(off + 10.0, share, 600.0, turn), 2u) << share << " " << turn;
    }
  }
}

TEST(Rank, PartsThatShareNothingBothStay) {
  EXPECT_EQ(leftOfTwo(101.0, 0.0), 2u);
  EXPECT_EQ(leftOfTwo(80.0, 0.0), 1u);
  EXPECT_EQ(leftOfTwo(0.0, 1.0), 2u);  // none shares more than all
  // The middle of the outermost of the grid's 16 cells is 3.1 mm off the border.
  for (const double turn : {0.0, 90.0}) {
    EXPECT_EQ(leftOfTwo(95.8, 0.0, 600.0, turn), 1u) << turn;
    EXPECT_EQ(leftOfTwo(97.6, 0.0, 600.0, turn), 2u) << turn;
  }
}

TEST(Rank, TheAreaIsThatOfThePictureAtAnyDepth) {
  // Farther away the same shift in millimetres is the same share.
  EXPECT_EQ(leftOfTwo(40.0, 0.5, 1800.0), 1u);
  EXPECT_EQ(leftOfTwo(60.0, 0.5, 1800.0), 2u);
}

TEST(Rank, ASmallPartOnALargeOneTakesNoPlace) {
  // All of the small one lies over the large one, a few per cent of the large one under it.
  sim::Plate small, large;
  small.outer = rectangle(-10, -10, 10, 10);
  large.outer = rectangle(-80, -60, 80, 60);
  const Parts parts = {makePart("small", small), makePart("large", large)};
  for (const bool small_is_better : {true, false}) {
    const auto out = rankPoses({scoredAt(0, small_is_better ? 0.9 : 0.7, 1.0, 0),
                                scoredAt(20, small_is_better ? 0.7 : 0.9, 1.0, 1)},
                               parts, 0.5, {});
    ASSERT_EQ(out.size(), 2u);
    EXPECT_EQ(out[0].part_name, small_is_better ? "small" : "large");
  }
}

TEST(Rank, OnePartTakesItsPlaceAtAnyDistance) {
  // Half as far away on the same ray it is seen twice as large.
  ScoredPose far = scoredAt(0, 0.9), near = scoredAt(0, 0.8);
  near.T_camera_part.translation() *= 0.5;
  EXPECT_EQ(rankPoses({far, near}, kParts, 0.5, {}).size(), 1u);
}

TEST(Rank, TheVisibleFaceCounts) {
  // A block of 40 mm: its back is 40 mm beyond its origin, nearer to the camera when it is up.
  sim::Plate block;
  block.outer = rectangle(-20, -20, 20, 20);
  block.thickness_mm = 40.0;
  const Parts parts = {makePart("block", block)};
  const auto lying = [](double x_mm, double z_mm, bool front, double score) {
    ScoredPose pose;
    static_cast<RefinedPose&>(pose) = refinedAt(sim::poseOf({x_mm, 0, z_mm, 0, 0, 0, front}));
    pose.score = score;
    pose.evidence.edges = score;
    pose.visible_fraction = 1.0;
    return pose;
  };
  // At 200 mm the back's face, 40 mm nearer than its origin, is where the front's is at 160 mm.
  EXPECT_EQ(
      rankPoses({lying(60, 160, true, 0.9), lying(60, 200, false, 0.8)}, parts, 0.5, {}).size(),
      1u);
  EXPECT_EQ(rankPoses({lying(60, 200, true, 0.9), lying(60 + 27, 200, false, 0.8)}, parts, 0.5, {})
                .size(),
            2u);
}

TEST(Rank, AHollowOutlineIsJudgedByItsOwnShape) {
  // Two L-shaped brackets, one turned by half a circle: their boxes share all, they themselves
  // little.
  ScoredPose a = scoredAt(0, 0.9), b = scoredAt(0, 0.8);
  const Eigen::Vector2d c = kParts[0]->center();
  b.T_camera_part = a.T_camera_part * Eigen::Translation3d(c.x(), c.y(), 0.0) *
                    Eigen::AngleAxisd(180.0 * kDegrees, Eigen::Vector3d::UnitZ()) *
                    Eigen::Translation3d(-c.x(), -c.y(), 0.0);
  EXPECT_EQ(rankPoses({a, b}, kParts, 0.5, {}).size(), 2u);
}

}  // namespace
}  // namespace planar_bin_picking
