// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/hypotheses.h"

#include "locate/refine/edge_offset.h"
#include "part/visible_face.h"
#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

constexpr double kMetres = 1e-3, kRadians = 1.5 * kDegrees;

/// Half the bracket: so small that its picture hardly tells the sign of the tilt.
sim::Plate smallBracket(double thickness_mm = 0.0) {
  sim::Plate plate = bracketPlate();
  for (auto& p : plate.outer) p *= 0.5;
  for (auto& hole : plate.holes)
    for (auto& p : hole) p *= 0.5;
  plate.thickness_mm = thickness_mm;
  return plate;
}

/// 60 x 40 mm: the one hole alone tells it from its half turn and from its other face.
sim::Plate oneHolePlate() {
  return {rectangle(-30, -20, 30, 20), {circle(17, 9, 4, true)}, {}, 0.0};
}

/// Near the optical axis, where tilts of either sign look most alike.
Eigen::Isometry3d tilted(double tilt_deg, double yaw_deg = 20.0, bool front = true) {
  return sim::poseOf({0, 0, 600, yaw_deg, tilt_deg, 70, front});
}

/// About the part's z.
Eigen::Isometry3d turned(const Eigen::Isometry3d& T_camera_part, double degrees) {
  return T_camera_part * Eigen::AngleAxisd(degrees * kDegrees, Eigen::Vector3d::UnitZ());
}

Eigen::Vector3d normalOf(const PoseHypothesis& pose) {
  return planar_bin_picking::normalOf(pose.T_camera_part, pose.face);
}

/// What the outline says of two tilts: by the mean of the points, and by how far their edges lie
/// off, of which five tell for themselves, to a twentieth of a pixel.
double outlineLead(const ChosenPose& chosen) {
  const PoseHypothesis &pose = chosen.pose, &other = *chosen.other_tilt;
  const auto residual = [](const PoseHypothesis& p) {
    return std::hypot(0.05, p.image.residual_px);
  };
  return (pose.inlier_score - other.inlier_score) / 0.05 +
         5.0 * std::log(residual(other) / residual(pose));
}

/// A scene with an aligner over it, for one part.
class Viewed {
 public:
  Viewed(const sim::Plate& plate, const sim::Scene& scene)
      : shot_(shoot(scene)),
        parts_{makePart("plate", plate)},
        aligner_(shot_.edges, shot_.camera, params_, parts_) {}
  Viewed(const sim::Plate& plate, const Eigen::Isometry3d& T_camera_part)
      : Viewed(plate, sceneAt(plate, T_camera_part)) {}
  Viewed(const Viewed&) = delete;
  Viewed& operator=(const Viewed&) = delete;

  static sim::Scene sceneAt(const sim::Plate& plate, const Eigen::Isometry3d& T_camera_part) {
    sim::Scene scene;
    scene.plates.push_back({plate, T_camera_part});
    return scene;
  }
  PoseHypothesis alignedAt(const Eigen::Isometry3d& T_camera_part) const {
    PoseHypothesis pose;
    pose.face = faceOf(T_camera_part);
    pose.T_camera_part = T_camera_part;
    aligner_.alignNarrow(&pose);
    return pose;
  }
  ChosenPose chosenFrom(const Eigen::Isometry3d& T_camera_part) const {
    return chooseHypothesis(aligner_, params_, alignedAt(T_camera_part));
  }
  RefineParams& params() { return params_; }
  const Aligner& aligner() const { return aligner_; }
  const Parts& parts() const { return parts_; }

 private:
  RefineParams params_;
  Shot shot_;
  Parts parts_;
  Aligner aligner_;
};

TEST(OtherTilt, TheOutlineTellsWhichIsRight) {
  const Eigen::Isometry3d truth = tilted(12.0);
  const Viewed viewed(smallBracket(), truth);
  for (const double start : {12.0, -12.0}) {
    const ChosenPose chosen = viewed.chosenFrom(tilted(start));
    EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, kMetres, kRadians)) << start;
    ASSERT_TRUE(chosen.other_tilt) << start;
    EXPECT_LT(Eigen::AngleAxisd(tilted(-12.0).linear().transpose() *
                                chosen.other_tilt->T_camera_part.linear())
                  .angle(),
              5.0 * kDegrees);
    EXPECT_NEAR(chosen.lead, outlineLead(chosen), 1e-9);
    EXPECT_GT(chosen.lead, 0.0);
    EXPECT_EQ(chosen.other_tilt->image.status, AlignmentStatus::kAligned);
  }
}

TEST(OtherTilt, TheBackHasOneToo) {
  const Eigen::Isometry3d truth = tilted(12.0, 20.0, false);
  const Viewed viewed(smallBracket(), truth);
  const ChosenPose chosen = viewed.chosenFrom(tilted(-12.0, 20.0, false));
  EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, kMetres, kRadians));
  EXPECT_EQ(chosen.pose.face, Face::kBack);
  EXPECT_TRUE(chosen.other_tilt);
}

TEST(OtherTilt, OneThatTheOutlineRefutesIsNoRival) {
  const Eigen::Isometry3d truth = tilted(30.0);
  const ChosenPose chosen = Viewed(bracketPlate(), truth).chosenFrom(truth);
  EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, kMetres, kRadians));
  EXPECT_FALSE(chosen.other_tilt);
  EXPECT_EQ(chosen.lead, 0.0);
}

TEST(OtherTilt, AFlatPartHasNone) {
  const Eigen::Isometry3d truth = tilted(0.5);
  EXPECT_FALSE(Viewed(smallBracket(), truth).chosenFrom(truth).other_tilt);
}

TEST(OtherTilt, BeyondTheLimitAndItsSlackThereIsNone) {
  const Eigen::Isometry3d truth = tilted(12.0);
  Viewed viewed(smallBracket(), truth);
  viewed.params().tilt_limit_deg = 5.0;
  EXPECT_TRUE(viewed.chosenFrom(truth).other_tilt);
  viewed.params().tilt_limit_deg = 0.0;
  EXPECT_FALSE(viewed.chosenFrom(truth).other_tilt);
}

TEST(OtherTilt, TheSideWallTellsToo) {
  const sim::Plate plate = smallBracket(10.0);
  const Eigen::Isometry3d truth = tilted(12.0);
  sim::Scene scene;
  // The wall is what the upper face leaves of the lower one.
  scene.plates.push_back({smallBracket(), truth * Eigen::Translation3d(0.0, 0.0, -0.010), 105.0});
  scene.plates.push_back({smallBracket(), truth});
  const Viewed viewed(plate, scene);
  for (const double start : {12.0, -12.0}) {
    const ChosenPose chosen = viewed.chosenFrom(tilted(start));
    EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, kMetres, kRadians)) << start;
    ASSERT_TRUE(chosen.other_tilt) << start;
    const auto wall = viewed.aligner().wallScoreOf(chosen.pose);
    const auto other_wall = viewed.aligner().wallScoreOf(*chosen.other_tilt);
    ASSERT_TRUE(wall && other_wall);
    EXPECT_GT(*wall, *other_wall + 0.1);
    EXPECT_NEAR(chosen.lead, outlineLead(chosen) + (*wall - *other_wall) / 0.075, 1e-9);
  }
}

TEST(NearSymmetry, ThePointsThatDifferDecide) {
  for (const bool front : {true, false}) {
    const Eigen::Isometry3d truth = tilted(3.0, 20.0, front);
    const Viewed viewed(oneHolePlate(), truth);
    const Eigen::Isometry3d over =
        truth * Eigen::AngleAxisd(180.0 * kDegrees, Eigen::Vector3d::UnitX());
    for (const auto& start : {truth, turned(truth, 180.0), over, turned(over, 180.0)}) {
      const ChosenPose chosen = viewed.chosenFrom(start);
      EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, kMetres, kRadians));
      EXPECT_EQ(chosen.pose.face, faceOf(truth));
      EXPECT_EQ(chosen.pose.image.status, AlignmentStatus::kAligned);
    }
  }
}

TEST(NearSymmetry, WhereNothingDiffersThePoseStays) {
  // The hole is covered, so none of the poses is better.
  sim::Plate drawn = oneHolePlate();
  drawn.holes.clear();
  const Eigen::Isometry3d truth = tilted(3.0);
  const Viewed viewed(oneHolePlate(), Viewed::sceneAt(drawn, truth));
  for (const double turn : {0.0, 180.0}) {
    const PoseHypothesis chosen = viewed.chosenFrom(turned(truth, turn)).pose;
    EXPECT_EQ(chosen.face, Face::kFront);
    EXPECT_TRUE(isometryNear(chosen.T_camera_part, turned(truth, turn), kMetres, kRadians)) << turn;
  }
}

TEST(NearSymmetry, NotWhereTheWholeOutlineFitsWorse) {
  // A step in the long side tells the half turn from the pose by 1.2 mm, which counts as alike; a
  // blot looks like the hole of the half turn.
  sim::Plate plate = oneHolePlate();
  plate.outer = {{-30, -20}, {30, -20}, {30, 20}, {0, 20}, {0, 18.8}, {-30, 18.8}};
  sim::Plate drawn = plate;
  drawn.holes = {circle(-17, -9.6, 4, true)};
  const Eigen::Isometry3d truth = tilted(3.0);
  const Viewed viewed(plate, Viewed::sceneAt(drawn, truth));
  EXPECT_TRUE(isometryNear(viewed.chosenFrom(truth).pose.T_camera_part, truth, kMetres, kRadians));
  // Without the step the blot does decide.
  drawn.outer = oneHolePlate().outer;
  drawn.holes = {circle(-17, -9, 4, true)};
  const Viewed even(oneHolePlate(), Viewed::sceneAt(drawn, truth));
  EXPECT_TRUE(isometryNear(even.chosenFrom(truth).pose.T_camera_part, turned(truth, 180.0), kMetres,
                           kRadians));
}

TEST(NearSymmetry, MayCostTheWholeOutlineTwoHundredths) {
  // A shorter step is worth less than the blot, and its length decides.
  for (const auto& [step_mm, decides] : {std::pair{10.0, true}, {12.0, false}}) {
    sim::Plate plate = oneHolePlate();
    const double x = step_mm - 30.0;
    plate.outer = {{-30, -20}, {30, -20}, {30, 20}, {x, 20}, {x, 18.8}, {-30, 18.8}};
    sim::Plate drawn = plate;
    drawn.holes = {circle(-17, -9.6, 4, true)};
    const Eigen::Isometry3d truth = tilted(3.0);
    const Viewed viewed(plate, Viewed::sceneAt(drawn, truth));
    const double cost =
        viewed.alignedAt(truth).inlier_score - viewed.alignedAt(turned(truth, 180.0)).inlier_score;
    ASSERT_GT(cost, decides ? 0.01 : 0.025);
    ASSERT_LT(cost, decides ? 0.018 : 0.038);
    const Eigen::Isometry3d expected = decides ? turned(truth, 180.0) : truth;
    EXPECT_TRUE(
        isometryNear(viewed.chosenFrom(truth).pose.T_camera_part, expected, kMetres, kRadians))
        << step_mm;
  }
}

TEST(NearSymmetry, TheOtherTiltMovesAlong) {
  sim::Plate plate{rectangle(-16, -10, 16, 10), {circle(9, 4, 3, true)}, {}, 0.0};
  const Eigen::Isometry3d truth = tilted(10.0);
  const Viewed viewed(plate, truth);
  const ChosenPose chosen = viewed.chosenFrom(turned(truth, 180.0));
  EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, kMetres, kRadians));
  ASSERT_TRUE(chosen.other_tilt);
  EXPECT_TRUE(
      isometryNear(chosen.other_tilt->T_camera_part, tilted(-10.0), 2 * kMetres, 2.0 * kRadians));
  EXPECT_EQ(chosen.other_tilt->face, chosen.pose.face);
}

TEST(Print, TellsTheFaceAndTheTurn) {
  for (const bool front : {true, false}) {
    const Eigen::Isometry3d truth = tilted(3.0, 20.0, front);
    const Viewed viewed(printedPlate(), truth);
    const Eigen::Isometry3d over =
        truth * Eigen::AngleAxisd(180.0 * kDegrees, Eigen::Vector3d::UnitX());
    for (const auto& start : {truth, turned(truth, 90.0), turned(truth, 180.0), over}) {
      const ChosenPose chosen = viewed.chosenFrom(start);
      EXPECT_EQ(chosen.pose.face, faceOf(truth));
      EXPECT_EQ(chosen.pose.image.status, AlignmentStatus::kAligned);
      EXPECT_EQ(faceOf(chosen.pose.T_camera_part), faceOf(truth));
      if (front) {  // from behind all quarters look alike
        EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, kMetres, kRadians));
      }
    }
  }
}

TEST(Print, DecidesBetweenNearSymmetriesWhereTheOutlineDoesNot) {
  sim::Plate plate = oneHolePlate();
  plate.prints = {rectangle(-20, -14, 8, -4)};
  sim::Plate drawn = plate;
  drawn.holes.clear();  // covered
  const Eigen::Isometry3d truth = tilted(3.0);
  const Viewed viewed(plate, Viewed::sceneAt(drawn, truth));
  const Eigen::Isometry3d over =
      truth * Eigen::AngleAxisd(180.0 * kDegrees, Eigen::Vector3d::UnitX());
  for (const auto& start : {truth, turned(truth, 180.0), over}) {
    const PoseHypothesis chosen = viewed.chosenFrom(start).pose;
    EXPECT_EQ(chosen.face, Face::kFront);
    EXPECT_TRUE(isometryNear(chosen.T_camera_part, truth, kMetres, kRadians));
  }
}

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
    decideTilts(viewed_.aligner(), &poses);
    const Eigen::Vector3d axis(std::cos(70 * kDegrees), std::sin(70 * kDegrees), 0.0);
    const Eigen::Vector3d up = -Eigen::Vector3d::UnitZ(), n = normalOf(poses[0].pose);
    return std::asin(up.cross(n).dot(axis)) / kDegrees;
  }
  Eigen::Isometry3d truth_ = tilted(10.0);
  Viewed viewed_{smallBracket(), truth_};
};

TEST_F(DecideTilts, AnAmbiguousOneTurnsToTheWayTheOthersLie) {
  std::vector<ChosenPose> poses = posesOf(-10.0, 1.0, 6, 10.0);
  EXPECT_NEAR(decided(poses), 10.0, 1.0);
  decideTilts(viewed_.aligner(), &poses);
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
    decideTilts(viewed_.aligner(), &poses);
    const RefinedPose refined{0, Face::kFront, poses[0].pose.T_camera_part};
    return otherTiltOf(viewed_.aligner(), poses[0], refined).tail<3>().norm() / kDegrees;
  };
  EXPECT_NEAR(degrees(0.0, 0, 0.0), 20.0 * std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(degrees(-std::log(3.0), 0, 0.0), 10.0, 0.3);
  EXPECT_LT(degrees(0.0, 6, 10.0), 6.0);
}

}  // namespace
}  // namespace planar_bin_picking
