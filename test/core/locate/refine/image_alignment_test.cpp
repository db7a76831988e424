// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/image_alignment.h"

#include "planar_bin_picking/base/se3.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr SearchProfile kReach{4, true, 0.8};
constexpr double kTukeyPx = 3.0;
const auto kBracket = makePart("bracket", bracketPlate());

bool isShape(const OutlinePoint& p) { return p.kind != LoopKind::kPrint; }

const sim::Lie kLie{20, -10, 600, 30, 12, 60};

/// The pose of a drawn bracket, from these of its points.
ImagePose poseFrom(const Shot& shot, const std::vector<LocalPoint>& points) {
  const Eigen::Isometry3d T = sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront);
  return alignInImage(shot.edges, shot.camera, points, solidOf(*kBracket, Face::kFront), T, kReach,
                      kTukeyPx);
}

double widest(const ImagePose& pose) {
  return std::sqrt(
      Eigen::SelfAdjointEigenSolver<Matrix6d>(pose.covariance).eigenvalues().maxCoeff());
}

TEST(ImageAlignment, TooFewEdgesLeaveEverythingOpen) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto all = localPoints(*kBracket, 320, isShape);
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{7}}) {
    std::vector<LocalPoint> few;
    for (std::size_t i = 0; i < count; ++i) few.push_back(all[i * all.size() / 7]);
    const ImagePose pose = poseFrom(shot, few);
    EXPECT_EQ(pose.used, static_cast<int>(count));
    EXPECT_EQ(pose.status, AlignmentStatus::kTooFewEdges);
    EXPECT_FALSE(std::isfinite(pose.offset_sigma));
    // A radius and a radian, in every direction.
    EXPECT_TRUE(pose.covariance.isApprox(Matrix6d::Identity()));
  }
}

TEST(ImageAlignment, FewerEdgesAreWorthLess) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  double last = 0.0;
  for (const int count : {320, 80, 30, 16, 9}) {
    const ImagePose pose = poseFrom(shot, localPoints(*kBracket, count, isShape));
    ASSERT_EQ(pose.status, AlignmentStatus::kAligned);
    EXPECT_GT(widest(pose), last) << count << " points";
    last = widest(pose);
  }
  EXPECT_LT(widest(poseFrom(shot, localPoints(*kBracket, 320, isShape))), 0.03);
}

/// However many points lie on one straight side, nothing tells where along it the part lies, nor
/// how it is turned about it.
TEST(ImageAlignment, WhatNoEdgeHoldsStaysOpen) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  std::vector<LocalPoint> side;
  for (const auto& p : localPoints(*kBracket, 512, isShape)) {
    if (std::abs(p.tx) > 0.999 && kBracket->outline()[p.index].position.y() < -0.0285)
      side.push_back(p);
  }
  ASSERT_GT(side.size(), 40u);
  const ImagePose pose = poseFrom(shot, side);
  ASSERT_GE(pose.used, 40);
  Vector6d along = Vector6d::Zero();
  along(0) = 1.0;  // the side runs along the part's x
  EXPECT_GT(std::sqrt(along.dot(pose.covariance * along)), 0.5);
  // Where the others do not matter, across it is known well.
  EXPECT_LT(1.0 / std::sqrt(pose.covariance.inverse()(1, 1)), 0.01);
}

/// Of the pose against the true one: translation in radii, rotation in radians.
Vector6d errorOf(const Eigen::Isometry3d& T_camera_centre) {
  Vector6d xi =
      log((sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront)).inverse() * T_camera_centre);
  xi.head<3>() /= kBracket->radius();
  return xi;
}

TEST(ImageAlignment, MovesOntoTheEdges) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto points = localPoints(*kBracket, 320, isShape);
  const Eigen::Isometry3d T = sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront);
  for (const double side : {-1.0, 1.0}) {
    Vector6d off;  // some 2 pixels
    off << 0.01, -0.01, 0.01, 0.02, -0.02, 0.01;
    ImagePose pose;
    pose.T_camera_centre = stepped(T, side * off, kBracket->radius());
    for (int round = 0; round < 3; ++round) {
      pose = alignInImage(shot.edges, shot.camera, points, solidOf(*kBracket, Face::kFront),
                          pose.T_camera_centre, kReach, kTukeyPx);
    }
    EXPECT_EQ(pose.status, AlignmentStatus::kAligned);
    EXPECT_GT(pose.used, 300);
    EXPECT_LT(errorOf(pose.T_camera_centre).norm(), 0.15 * off.norm());
    EXPECT_LT(pose.residual_px, 0.3);
  }
}

TEST(ImageAlignment, TellsByHowMuchTheEdgesLieInside) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  for (const double inside : {-0.01, 0.0, 0.01}) {  // radii: 0.8 pixels
    auto points = localPoints(*kBracket, 320, isShape);
    moveInward(-inside, &points);  // drawn so much larger
    const ImagePose pose = poseFrom(shot, points);
    ASSERT_EQ(pose.status, AlignmentStatus::kAligned);
    EXPECT_NEAR(pose.offset, inside, 0.002) << inside;
    EXPECT_LT(std::abs(pose.offset - inside), 3.0 * pose.offset_sigma);
    EXPECT_LT(pose.offset_sigma, 0.004);
  }
}

TEST(ImageAlignment, SaysHowThePoseFollowsTheEdgeOffset) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto points = localPoints(*kBracket, 320, isShape);
  constexpr double kStep = 0.003;  // radii
  auto smaller = points, larger = points;
  moveInward(kStep, &smaller);
  moveInward(-kStep, &larger);
  const Vector6d slope = (errorOf(poseFrom(shot, smaller).T_camera_centre) -
                          errorOf(poseFrom(shot, larger).T_camera_centre)) /
                         (2.0 * kStep);
  const Vector6d said = poseFrom(shot, points).per_offset;
  EXPECT_GT(slope.norm(), 1.0);  // a smaller part is nearer
  EXPECT_LT((slope - said).norm(), 0.2 * slope.norm())
      << slope.transpose() << " but it says " << said.transpose();
}

/// Errors against what the covariance says of them, over many pictures of ten points each.
TEST(ImageAlignment, FewEdgesAreJudgedHonestly) {
  double sum = 0.0;
  constexpr int kPictures = 20;
  for (int seed = 1; seed <= kPictures; ++seed) {
    sim::Scene scene = sceneOf(bracketPlate(), kLie);
    scene.seed = seed;
    scene.noise = 6.0;
    std::vector<LocalPoint> points;
    const auto all = localPoints(*kBracket, 320, isShape);
    for (std::size_t i = 0; i < 10; ++i)
      points.push_back(
          all[(7u * static_cast<std::size_t>(seed) + i * all.size() / 10) % all.size()]);
    const ImagePose pose = poseFrom(shoot(scene), points);
    if (pose.used < kFewEdges) {
      EXPECT_TRUE(pose.covariance.isApprox(Matrix6d::Identity()));
      continue;
    }
    const Eigen::Isometry3d off =
        pose.T_camera_centre.inverse() * sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront);
    const Eigen::AngleAxisd turn(off.linear());
    Vector6d xi;
    xi << off.translation() / kBracket->radius(), turn.angle() * turn.axis();
    sum += xi.dot(pose.covariance.ldlt().solve(xi));
  }
  EXPECT_LT(sum / kPictures, 2.0 * 6.0);  // 6 per picture where it is exact
}

}  // namespace
}  // namespace planar_bin_picking
