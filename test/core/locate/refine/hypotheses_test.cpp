// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "support/matchers.h"
#include "viewed.h"

#include <gtest/gtest.h>

#include <utility>

namespace planar_bin_picking {
namespace {

/// What the outline says of two tilts: by the mean of the points, and by how far their edges lie
/// off, to a twentieth of a pixel, the less the farther both do.
double outlineLead(const ChosenPose& chosen) {
  const PoseHypothesis &pose = chosen.pose, &other = *chosen.other_tilt;
  const auto residual = [](const PoseHypothesis& p) {
    return std::hypot(0.05, p.image.residual_px);
  };
  const double least = std::min(residual(pose), residual(other)) / 0.4;
  return (pose.inlier_score - other.inlier_score) / 0.05 +
         10.0 * std::log(residual(other) / residual(pose)) / (1.0 + least * least);
}

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

/// A small bracket with a dark side wall.
sim::Scene withWalls(const Eigen::Isometry3d& truth, double thickness_mm) {
  sim::Scene scene;
  // The wall is what the upper face leaves of the lower one.
  scene.plates.push_back(
      {smallBracket(), truth * Eigen::Translation3d(0.0, 0.0, -1e-3 * thickness_mm), 105.0});
  scene.plates.push_back({smallBracket(), truth});
  return scene;
}

double bandLead(const Viewed& viewed, const ChosenPose& chosen) {
  return 12.0 * viewed.aligner().wallBandsOf(chosen.pose, *chosen.other_tilt);
}

TEST(OtherTilt, TheSideWallTellsToo) {
  const Eigen::Isometry3d truth = tilted(12.0);
  const Viewed viewed(smallBracket(10.0), withWalls(truth, 10.0));
  for (const double start : {12.0, -12.0}) {
    const ChosenPose chosen = viewed.chosenFrom(tilted(start));
    EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, kMetres, kRadians)) << start;
    ASSERT_TRUE(chosen.other_tilt) << start;
    const auto wall = viewed.aligner().wallScoreOf(chosen.pose);
    const auto other_wall = viewed.aligner().wallScoreOf(*chosen.other_tilt);
    ASSERT_TRUE(wall && other_wall);
    EXPECT_GT(*wall, *other_wall + 0.1);
    ASSERT_LT(*other_wall, 0.3);  // no more than chance gives
    EXPECT_NEAR(chosen.lead, outlineLead(chosen) + (*wall - 0.3) / 0.075 + bandLead(viewed, chosen),
                1e-9);
  }
}

TEST(OtherTilt, ANarrowSideWallTellsToo) {
  const Eigen::Isometry3d truth = tilted(8.0);
  const Viewed viewed(smallBracket(3.0), withWalls(truth, 3.0));
  for (const double start : {8.0, -8.0}) {
    const ChosenPose chosen = viewed.chosenFrom(tilted(start));
    // The wall draws some of the outline's edges to its own.
    EXPECT_TRUE(isometryNear(chosen.pose.T_camera_part, truth, 2 * kMetres, 2 * kRadians)) << start;
    ASSERT_TRUE(chosen.other_tilt) << start;
    EXPECT_FALSE(viewed.aligner().wallScoreOf(chosen.pose)) << "too narrow for that";
    EXPECT_GT(bandLead(viewed, chosen), 3.0);
    EXPECT_NEAR(chosen.lead, outlineLead(chosen) + bandLead(viewed, chosen), 1e-9);
  }
}

/// On a larger one, whose edges lie within the reach of a wide alignment, which goes there.
sim::Scene onALikePart(const Eigen::Isometry3d& truth) {
  sim::Plate larger = smallBracket(0.0, 1.1 * 0.35);
  larger.holes.clear();
  sim::Scene scene;
  scene.plates.push_back({larger, truth, 110.0});
  scene.plates.push_back({smallBracket(0.0, 0.35), truth});
  return scene;
}

TEST(OtherTilt, IsFoundAmongTheEdgesOfALikePart) {
  for (const double tilt_deg : {6.0, 8.0, 10.0}) {
    const Eigen::Isometry3d truth = tilted(tilt_deg);
    const ChosenPose chosen = Viewed(smallBracket(0.0, 0.35), onALikePart(truth)).chosenFrom(truth);
    ASSERT_TRUE(chosen.other_tilt) << tilt_deg;
    EXPECT_GT((normalOf(*chosen.other_tilt) - normalOf(chosen.pose)).norm(), 0.05) << tilt_deg;
    EXPECT_GT(chosen.other_tilt->inlier_score, 0.7) << tilt_deg;
  }
}

/// A narrow alignment would find one, held by the other edges.
TEST(OtherTilt, IsNotSoughtAmongThemWhereHalfIsCovered) {
  for (const auto& [tilt_deg, edge_mm] : {std::pair{8.0, 6.0}, {10.0, 2.0}, {12.0, 2.0}}) {
    const Eigen::Isometry3d truth = tilted(tilt_deg);
    sim::Scene scene = onALikePart(truth);
    scene.plates.push_back({{rectangle(edge_mm, -40, 40, 40), {}, {}, 0.0}, truth, 200.0});
    const ChosenPose chosen = Viewed(smallBracket(0.0, 0.35), scene).chosenFrom(truth);
    EXPECT_GT(chosen.pose.inlier_score, 0.5) << tilt_deg;
    EXPECT_FALSE(chosen.other_tilt) << tilt_deg;
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

}  // namespace
}  // namespace planar_bin_picking
