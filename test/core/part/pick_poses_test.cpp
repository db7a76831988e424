// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/pick_poses.h"

#include "support/matchers.h"
#include "support/plates.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kThickness = 0.004;

/// Tool down on the front face at (x, y).
PickPose downAt(double x, double y, const std::string& name = "web") {
  PickPose pose;
  pose.name = name;
  pose.face = FaceFilter::kFront;
  pose.T_part_pick = Eigen::Translation3d(x, y, 0.0) *
                     Eigen::AngleAxisd(180.0 * kDegrees, Eigen::Vector3d::UnitX());
  return pose;
}

Symmetry turnsAbout(double x, double y, int order, bool mirror = false) {
  Symmetry symmetry;
  symmetry.center = {x, y};
  symmetry.order = order;
  symmetry.mirror = mirror;
  return symmetry;
}

TEST(PickPoses, WithoutSymmetryStandAsGiven) {
  const auto all = withSymmetricCopies({downAt(0.01, 0.0), downAt(0.0, 0.02, "edge")}, {}, 0.0);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].name, "web");
  EXPECT_EQ(all[1].name, "edge");
}

TEST(PickPoses, AreCopiedByEachTurn) {
  const auto all = withSymmetricCopies({downAt(0.03, 0.02)}, turnsAbout(0.01, 0.02, 4), kThickness);
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0].name, "web");
  EXPECT_EQ(all[1].name, "web@2");
  EXPECT_EQ(all[3].name, "web@4");
  const Eigen::Vector3d expected[] = {
      {0.03, 0.02, 0}, {0.01, 0.04, 0}, {-0.01, 0.02, 0}, {0.01, 0.0, 0}};
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(all[i].T_part_pick.translation().isApprox(expected[i], 1e-9)) << i;
    EXPECT_NEAR(all[i].T_part_pick.linear()(2, 2), -1.0,
                1e-12);  // into the front face, all of them
    EXPECT_EQ(all[i].face, FaceFilter::kFront);
  }
  // The tool turns along, or a gripper would not fit.
  EXPECT_TRUE(all[1].T_part_pick.linear().col(0).isApprox(Eigen::Vector3d::UnitY(), 1e-9));
}

TEST(PickPoses, AMirroredPartHasThemOnItsOtherFace) {
  Symmetry symmetry = turnsAbout(0.0, 0.0, 1, true);
  symmetry.mirror_axis = 90.0 * kDegrees;
  const auto all = withSymmetricCopies({downAt(0.03, 0.02)}, symmetry, kThickness);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1].face, FaceFilter::kBack);
  EXPECT_TRUE(
      all[1].T_part_pick.translation().isApprox(Eigen::Vector3d(-0.03, 0.02, -kThickness), 1e-9));
  EXPECT_NEAR(all[1].T_part_pick.linear()(2, 2), 1.0, 1e-12);  // into the back face
}

TEST(PickPoses, PreferenceComesBeforeCopies) {
  const auto all =
      withSymmetricCopies({downAt(0.03, 0.0), downAt(0.0, 0.01, "edge")}, turnsAbout(0, 0, 2), 0.0);
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[1].name, "web@2");
  EXPECT_EQ(all[2].name, "edge");
  EXPECT_EQ(all[3].name, "edge@2");
}

TEST(PickPoses, ACopyThatIsGivenAnywayIsNotMade) {
  PickPose other = downAt(-0.03, 0.0, "far");
  other.T_part_pick.rotate(Eigen::AngleAxisd(180.0 * kDegrees, Eigen::Vector3d::UnitZ()));
  const auto all = withSymmetricCopies({downAt(0.03, 0.0), other}, turnsAbout(0, 0, 2), 0.0);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1].name, "far");
}

TEST(PickPoses, AreNotCopiedWhereAskedNotTo) {
  PickPose pose = downAt(0.03, 0.0);
  pose.symmetric = false;
  EXPECT_EQ(withSymmetricCopies({pose}, turnsAbout(0, 0, 6, true), kThickness).size(), 1u);
}

TEST(PickPoses, OfManyTurnsSomeEvenlySpread) {
  EXPECT_EQ(withSymmetricCopies({downAt(0.03, 0.0)}, turnsAbout(0, 0, 0), 0.0).size(), 12u);
  const auto all = withSymmetricCopies({downAt(0.03, 0.0)}, turnsAbout(0, 0, 30), 0.0);
  ASSERT_EQ(all.size(), 10u);
  const Eigen::Vector3d& next = all[1].T_part_pick.translation();
  EXPECT_NEAR(std::atan2(next.y(), next.x()), 36.0 * kDegrees, 1e-9);
}

TEST(PickPoses, OfAPartComeFromItsOutline) {
  PartFile file = makePart("wheel", wheelPlate(6, false))->file();
  file.pick_poses = {downAt(0.01, 0.0)};
  const PartModel part(file);
  EXPECT_EQ(part.pickPoses().size(), 12u);  // six turns, either face
}

}  // namespace
}  // namespace planar_bin_picking
