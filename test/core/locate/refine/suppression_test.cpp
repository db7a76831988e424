// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/suppression.h"

#include "support/plates.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace planar_bin_picking {
namespace {

using Indices = std::vector<std::size_t>;

constexpr double kDistance = 0.02, kScoreMin = 0.4;
constexpr int kMany = 100;

PartOutline outlineOf(const std::shared_ptr<const PartModel>& part) {
  PartOutline outline;
  outline.part = part.get();
  return outline;
}

PoseHypothesis poseAt(double x_mm, double score, double yaw_deg = 0.0, bool front = true) {
  PoseHypothesis pose;
  pose.T_camera_part = sim::poseOf({x_mm, 0, 600, yaw_deg, 0, 0, front});
  pose.face = front ? Face::kFront : Face::kBack;
  pose.inlier_score = score;
  return pose;
}

class Suppression : public testing::Test {
 protected:
  Indices withoutDuplicates(const std::vector<PoseHypothesis>& poses, double score_min = kScoreMin,
                            int max_poses = kMany, int min_poses = 0) const {
    return planar_bin_picking::withoutDuplicates(poses, outlines_, kDistance, score_min,
                                                 {min_poses, max_poses});
  }
  Indices withoutOutscored(const std::vector<PoseHypothesis>& poses,
                           double overlap_max = 0.5) const {
    return planar_bin_picking::withoutOutscored(poses, outlines_, overlap_max);
  }
  std::shared_ptr<const PartModel> bracket_ = makePart("bracket", bracketPlate());
  std::shared_ptr<const PartModel> square_ =
      makePart("square", {rectangle(-30, -30, 30, 30), {}, {}, 0.0});
  std::vector<PartOutline> outlines_ = {outlineOf(bracket_), outlineOf(square_)};
};

TEST_F(Suppression, TheBestComeFirst) {
  EXPECT_EQ(withoutDuplicates({poseAt(-100, 0.5), poseAt(0, 0.9), poseAt(100, 0.7)}),
            (Indices{1, 2, 0}));
}

TEST_F(Suppression, OfEqualScoresTheFirstStaysFirst) {
  EXPECT_EQ(withoutDuplicates({poseAt(-100, 0.5), poseAt(0, 0.5), poseAt(100, 0.5)}),
            (Indices{0, 1, 2}));
}

TEST_F(Suppression, TheLeastScoreItselfStays) {
  EXPECT_EQ(withoutDuplicates({poseAt(0, 0.39), poseAt(100, 0.4)}), Indices{1});
}

TEST_F(Suppression, NoneGivesNone) {
  EXPECT_TRUE(withoutDuplicates({}).empty());
  EXPECT_TRUE(withoutDuplicates({poseAt(0, 0.1)}).empty());
  EXPECT_TRUE(withoutOutscored({}).empty());
}

TEST_F(Suppression, MaxPosesCountsEachPartByItself) {
  std::vector<PoseHypothesis> poses = {poseAt(-200, 0.9), poseAt(-100, 0.8), poseAt(0, 0.7),
                                       poseAt(100, 0.6), poseAt(200, 0.5)};
  poses[3].part = poses[4].part = 1;
  EXPECT_EQ(withoutDuplicates(poses, kScoreMin, 2), (Indices{0, 1, 3, 4}));
  EXPECT_EQ(withoutDuplicates(poses, kScoreMin, 1), (Indices{0, 3}));
}

TEST_F(Suppression, TheBestOfEachPartStayHoweverLowTheirScores) {
  std::vector<PoseHypothesis> poses = {poseAt(-200, 0.1), poseAt(-100, 0.3), poseAt(0, 0.2),
                                       poseAt(100, 0.05), poseAt(200, 0.9)};
  poses[3].part = 1;
  EXPECT_EQ(withoutDuplicates(poses, kScoreMin, kMany, 2), (Indices{4, 1, 3}));
  // A duplicate is none of them.
  poses.push_back(poseAt(200, 0.8));
  EXPECT_EQ(withoutDuplicates(poses, kScoreMin, kMany, 2), (Indices{4, 1, 3}));
}

TEST_F(Suppression, ADuplicateDoesNotCountAmongMaxPoses) {
  EXPECT_EQ(withoutDuplicates({poseAt(0, 0.9), poseAt(0, 0.8), poseAt(100, 0.7)}, kScoreMin, 2),
            (Indices{0, 2}));
}

TEST_F(Suppression, OfPosesThatAgreeOnlyTheBestStays) {
  const double radius_mm = 1e3 * bracket_->radius();
  const double near = 0.9 * kDistance * radius_mm, far = 1.1 * kDistance * radius_mm;
  EXPECT_EQ(withoutDuplicates({poseAt(0, 0.6), poseAt(near, 0.9)}), Indices{1});
  EXPECT_EQ(withoutDuplicates({poseAt(0, 0.6), poseAt(far, 0.9)}), (Indices{1, 0}));
}

TEST_F(Suppression, WhatAgreesOnlyWithASuppressedPoseStays) {
  // A chain: the middle one goes, so it can suppress nothing itself.
  const double step_mm = 0.7 * kDistance * 1e3 * bracket_->radius();
  EXPECT_EQ(withoutDuplicates({poseAt(0, 0.9), poseAt(step_mm, 0.8), poseAt(2 * step_mm, 0.7)}),
            (Indices{0, 2}));
}

TEST_F(Suppression, FacesAreNotDuplicatesOfEachOther) {
  std::vector<PoseHypothesis> poses = {poseAt(0, 0.9), poseAt(0, 0.8)};
  poses[1].face = Face::kBack;
  EXPECT_EQ(withoutDuplicates(poses), (Indices{0, 1}));
}

TEST_F(Suppression, PartsAreNotDuplicatesOfEachOther) {
  std::vector<PoseHypothesis> poses = {poseAt(0, 0.9), poseAt(0, 0.8)};
  poses[1].part = 1;
  EXPECT_EQ(withoutDuplicates(poses), (Indices{0, 1}));
}

TEST_F(Suppression, PosesThatASymmetryMakesEqualAreOne) {
  std::vector<PoseHypothesis> poses = {poseAt(0, 0.9), poseAt(0, 0.8, 90.0), poseAt(0, 0.7, 45.0)};
  EXPECT_EQ(withoutDuplicates(poses), (Indices{0, 1, 2}));  // the bracket has no symmetry
  for (auto& pose : poses) pose.part = 1;
  EXPECT_EQ(withoutDuplicates(poses), (Indices{0, 2}));
}

TEST_F(Suppression, OutscoredIsOnlyByAClearLead) {
  EXPECT_EQ(withoutOutscored({poseAt(0, 0.70), poseAt(1, 0.83)}), Indices{1});
  EXPECT_EQ(withoutOutscored({poseAt(0, 0.70), poseAt(1, 0.81)}), (Indices{0, 1}));
  EXPECT_EQ(withoutOutscored({poseAt(0, 0.83), poseAt(1, 0.70)}), Indices{0});
}

TEST_F(Suppression, TheLeadMustBeMoreThanTheMargin) {
  EXPECT_EQ(withoutOutscored({poseAt(0, 0.5), poseAt(1, 0.5 + 0.12)}), (Indices{0, 1}));
}

TEST_F(Suppression, OutscoredIsOnlyWhereMoreThanHalfIsCommon) {
  // Squares of 60 mm, at the same distance.
  std::vector<PoseHypothesis> near = {poseAt(0, 0.5), poseAt(27, 0.9)};
  std::vector<PoseHypothesis> far = {poseAt(0, 0.5), poseAt(33, 0.9)};
  for (auto* poses : {&near, &far})
    for (PoseHypothesis& pose : *poses) pose.part = 1;
  EXPECT_EQ(withoutOutscored(near), Indices{1});
  EXPECT_EQ(withoutOutscored(far), (Indices{0, 1}));
}

TEST_F(Suppression, TheShareThatIsTooMuchIsGiven) {
  // Squares of 60 mm have 0.75 in common where they are 15 mm apart.
  std::vector<PoseHypothesis> poses = {poseAt(0, 0.5), poseAt(15, 0.9)};
  for (PoseHypothesis& pose : poses) pose.part = 1;
  EXPECT_EQ(withoutOutscored(poses, 0.65), Indices{1});
  EXPECT_EQ(withoutOutscored(poses, 0.85), (Indices{0, 1}));
  EXPECT_EQ(withoutOutscored({poseAt(0, 0.5), poseAt(0, 0.9)}, 1.0), (Indices{0, 1}));
}

TEST_F(Suppression, TheCommonShareIsThatOfEitherFace) {
  // Half as far away on the same ray a square is seen twice as large, so a quarter of it is common,
  // and all of the other.
  std::vector<PoseHypothesis> poses = {poseAt(0, 0.5), poseAt(0, 0.5)};
  poses[0].part = poses[1].part = 1;
  poses[1].T_camera_part.translation() *= 0.5;
  for (const std::size_t better : {0, 1}) {
    poses[better].inlier_score = 0.9;
    EXPECT_EQ(withoutOutscored(poses), Indices{better});
    poses[better].inlier_score = 0.5;
  }
}

TEST_F(Suppression, AnotherPartOutscoresAsWell) {
  std::vector<PoseHypothesis> poses = {poseAt(0, 0.5), poseAt(0, 0.9)};
  poses[1].part = 1;
  EXPECT_EQ(withoutOutscored(poses), Indices{1});
}

TEST_F(Suppression, ASmallPartOnALargeOneIsNotOutscored) {
  const auto washer = makePart("washer", {rectangle(-8, -8, 8, 8), {}, {}, 0.0});
  outlines_.push_back(outlineOf(washer));
  std::vector<PoseHypothesis> poses = {poseAt(0, 0.5), poseAt(10, 0.9)};
  poses[0].part = 2, poses[1].part = 1;
  EXPECT_EQ(withoutOutscored(poses), (Indices{0, 1}));
  std::swap(poses[0].inlier_score, poses[1].inlier_score);
  EXPECT_EQ(withoutOutscored(poses), (Indices{0, 1}));
}

TEST_F(Suppression, WhatIsOutscoredOutscoresNone) {
  // Each of three squares covers three fifths of the next one; the outer two have a fifth in
  // common.
  std::vector<PoseHypothesis> poses = {poseAt(0, 0.95), poseAt(24, 0.8), poseAt(48, 0.6)};
  for (PoseHypothesis& pose : poses) pose.part = 1;
  EXPECT_EQ(withoutOutscored(poses), (Indices{0, 2}));
}

TEST_F(Suppression, TheFaceIsSeenAsItIsTilted) {
  // Squares of 60 mm, 40 mm apart: seen at 60 degrees each is half as wide.
  const auto tilted = [](double x_mm, double score) {
    PoseHypothesis pose;
    pose.part = 1;
    pose.T_camera_part = sim::poseOf({x_mm, 0, 600, 0, 0, 60, true});
    pose.inlier_score = score;
    return pose;
  };
  EXPECT_EQ(withoutOutscored({tilted(0, 0.5), tilted(10, 0.9)}), Indices{1});
  EXPECT_EQ(withoutOutscored({tilted(0, 0.5), tilted(40, 0.9)}), (Indices{0, 1}));
}

TEST_F(Suppression, TheOutscoredKeepTheirOrder) {
  EXPECT_EQ(
      withoutOutscored({poseAt(-100, 0.5), poseAt(0, 0.6), poseAt(1, 0.9), poseAt(100, 0.95)}),
      (Indices{0, 2, 3}));
}

TEST(KeepOnly, LeavesThoseInTheirOrder) {
  std::vector<std::string> all = {"a", "b", "c", "d"};
  keepOnly({3, 1}, &all);
  EXPECT_EQ(all, (std::vector<std::string>{"d", "b"}));
  keepOnly({}, &all);
  EXPECT_TRUE(all.empty());
}

}  // namespace
}  // namespace planar_bin_picking
