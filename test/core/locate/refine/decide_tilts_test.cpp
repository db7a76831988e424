// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/edge_offset.h"
#include "support/matchers.h"
#include "viewed.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

/// One small bracket whose tilt is 10 degrees, either way, among others that are only told of.
class DecideTilts : public testing::Test {
 protected:
  /// As if aligned to a thousandth of a radian.
  static PoseHypothesis toldAt(const Eigen::Isometry3d& T_camera_part, const PartModel& part) {
    PoseHypothesis pose;
    pose.face = faceOf(T_camera_part);
    pose.T_camera_part = T_camera_part;
    pose.inlier_score = 0.9;
    pose.image.status = AlignmentStatus::kAligned;
    pose.image.T_camera_centre = T_camera_part * centreOf(part, pose.face);
    pose.image.covariance = 1e-6 * Matrix6d::Identity();
    return pose;
  }
  /// @param place  0 = in the picture; others are apart from one another
  PoseHypothesis told(double tilt_deg, int place = 0) const {
    const Eigen::Translation3d there(0.3 * place, 0.0, 0.0);
    return toldAt(there * tilted(tilt_deg), *viewed_.parts()[0]);
  }
  /// The first of `tilt_deg` with its other, and `count` sure ones of `others_deg`.
  std::vector<ChosenPose> posesOf(double tilt_deg, double lead, int count,
                                  double others_deg) const {
    std::vector<ChosenPose> poses = {{told(tilt_deg), told(-tilt_deg), lead}};
    for (int i = 0; i < count; ++i) poses.push_back({told(others_deg, i + 1), std::nullopt, 0.0});
    return poses;
  }
  /// Of the first pose once decided, degrees about the axis of tilted().
  double decided(std::vector<ChosenPose> poses) const {
    decideTilts(viewed_.aligner(), floor_, &poses);
    const Eigen::Vector3d axis(std::cos(70 * kDegrees), std::sin(70 * kDegrees), 0.0);
    const Eigen::Vector3d up = -Eigen::Vector3d::UnitZ(), n = normalOf(poses[0].pose);
    return std::asin(up.cross(n).dot(axis)) / kDegrees;
  }
  std::optional<Eigen::Vector3d> floor_;
  Eigen::Isometry3d truth_ = tilted(10.0);
  Viewed viewed_{smallBracket(), truth_};
};

TEST_F(DecideTilts, AnAmbiguousOneTurnsToTheWayTheOthersLie) {
  std::vector<ChosenPose> poses = posesOf(-10.0, 1.0, 6, 10.0);
  EXPECT_NEAR(decided(poses), 10.0, 1.0);
  decideTilts(viewed_.aligner(), floor_, &poses);
  // Aligned anew: with the score that the picture gives, and with the other in its place.
  EXPECT_NE(poses[0].pose.inlier_score, 0.9);
  EXPECT_TRUE(isometryNear(poses[0].pose.T_camera_part, truth_, kMetres, kRadians));
  EXPECT_TRUE(isometryNear(poses[0].other_tilt->T_camera_part, tilted(-10.0), 1e-9, 1e-6));
}

TEST_F(DecideTilts, ASureOneIsLeftAndSoIsOneWithoutAnother) {
  EXPECT_NEAR(decided(posesOf(-10.0, 50.0, 6, 10.0)), -10.0, 1e-6);
  std::vector<ChosenPose> poses = posesOf(-10.0, 0.0, 6, 10.0);
  poses[0].other_tilt.reset();
  EXPECT_NEAR(decided(poses), -10.0, 1e-6);
}

TEST_F(DecideTilts, NoOthersSayNothing) {
  EXPECT_NEAR(decided(posesOf(-10.0, 0.0, 0, 10.0)), -10.0, 1e-6);
  EXPECT_NEAR(decided(posesOf(-10.0, 0.0, 1, 10.0)), 10.0, 1.0);
}

TEST_F(DecideTilts, OthersThatHardlyFitSayNothing) {
  std::vector<ChosenPose> poses = posesOf(-10.0, 0.0, 6, 10.0);
  for (std::size_t i = 1; i < poses.size(); ++i) poses[i].pose.inlier_score = 0.69;
  EXPECT_NEAR(decided(poses), -10.0, 1e-6);
}

TEST_F(DecideTilts, OfSeveralAboutOnePlaceTheBestCounts) {
  std::vector<ChosenPose> poses = posesOf(-10.0, 0.0, 2, 10.0);
  for (int i = 0; i < 6; ++i) {
    poses.push_back({told(-10.0, 1), std::nullopt, 0.0});
    poses.back().pose.inlier_score = 0.89;
  }
  EXPECT_NEAR(decided(poses), 10.0, 1.0);
}

TEST_F(DecideTilts, WhatIsDecidedOfOneTellsOfTheNext) {
  std::vector<ChosenPose> poses = posesOf(-10.0, 0.6, 0, 0.0);
  for (int i = 1; i <= 6; ++i) poses.push_back({told(-10.0, i), told(10.0, i), 0.2});
  for (int i = 7; i <= 8; ++i) poses.push_back({told(10.0, i), std::nullopt, 0.0});
  EXPECT_NEAR(decided(poses), 10.0, 1.0);
}

TEST_F(DecideTilts, OfOthersThatLieEitherWayTheSurerCount) {
  const auto with = [&](double lead_right, double lead_wrong) {
    std::vector<ChosenPose> poses = posesOf(-10.0, 0.5, 0, 0.0);
    for (int i = 1; i <= 3; ++i) poses.push_back({told(10.0, i), told(-10.0, i), lead_right});
    for (int i = 4; i <= 8; ++i) poses.push_back({told(-10.0, i), told(10.0, i), lead_wrong});
    return decided(poses);
  };
  EXPECT_NEAR(with(6.0, 0.0), 10.0, 1.0);
  EXPECT_NEAR(with(6.0, 6.0), -10.0, 1e-6);
}

/// Against a plane that is known to a fraction of a degree, of a part that lies on it in nine of
/// ten cases, 20 degrees are two standard deviations of 10 degrees off: odds of some exp(-2 * 2) /
/// 2 and what a part that lies anyhow adds.
TEST_F(DecideTilts, ThePosesOwnTiltErrorSetsTheOdds) {
  const auto with = [&](double lead) {
    std::vector<ChosenPose> poses = posesOf(-10.0, lead, 6, 10.0);
    poses[0].pose.image.covariance(3, 3) = poses[0].pose.image.covariance(4, 4) = 0.01;
    return decided(poses);
  };
  EXPECT_NEAR(with(4.2), 10.0, 1.0);
  EXPECT_NEAR(with(5.4), -10.0, 1e-6);
}

TEST_F(DecideTilts, APoseThatHardlyTellsItsTiltIsLeft) {
  std::vector<ChosenPose> poses = posesOf(-10.0, 1.0, 6, 10.0);
  poses[0].pose.image.covariance = Matrix6d::Identity();
  EXPECT_NEAR(decided(poses), -10.0, 1e-6);
}

TEST_F(DecideTilts, TheOtherTiltStaysByItsOdds) {
  const auto degrees = [&](double lead, int others, double others_deg) {
    std::vector<ChosenPose> poses = posesOf(-10.0, lead, others, others_deg);
    decideTilts(viewed_.aligner(), floor_, &poses);
    const RefinedPose refined{0, Face::kFront, poses[0].pose.T_camera_part};
    return otherTiltOf(viewed_.aligner(), poses[0], refined).tail<3>().norm() / kDegrees;
  };
  EXPECT_NEAR(degrees(0.0, 0, 0.0), 20.0 * std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(degrees(-std::log(3.0), 0, 0.0), 10.0, 0.3);
  EXPECT_LT(degrees(0.0, 6, 10.0), 6.0);
}

TEST_F(DecideTilts, WhatIsNoNumberLeavesEvenOdds) {
  std::vector<ChosenPose> poses = posesOf(-10.0, std::nan(""), 0, 0.0);
  decideTilts(viewed_.aligner(), floor_, &poses);
  EXPECT_EQ(poses[0].odds, 0.0);
  EXPECT_TRUE(isometryNear(poses[0].pose.T_camera_part, tilted(-10.0), 1e-9, 1e-6));
}

TEST_F(DecideTilts, ABinsFloorCountsAsTwoOthers) {
  floor_ = planar_bin_picking::normalOf(tilted(10.0), Face::kFront);
  EXPECT_NEAR(decided(posesOf(-10.0, 1.0, 0, 0.0)), 10.0, 1.0);
  EXPECT_NEAR(decided(posesOf(-10.0, 50.0, 0, 0.0)), -10.0, 1e-6);
  // Where many lie otherwise, they know better.
  EXPECT_NEAR(decided(posesOf(-10.0, 0.0, 8, -10.0)), -10.0, 1e-6);
}

}  // namespace
}  // namespace planar_bin_picking
