// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/scene_plane_prior.h"

#include "part/outline_view.h"
#include "support/plates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = EIGEN_PI / 180.0;

const std::vector<std::shared_ptr<const PartModel>> kParts = {makePart("bracket", bracketPlate())};

/// A face tilted by x, y degrees from facing the camera, its tilt measured to `sigma_deg`.
RefinedPose poseAt(Face face, double x_deg, double y_deg, double sigma_deg) {
  RefinedPose pose;
  pose.face = face;
  pose.T_camera_part.translation() << 0.01, 0.02, 0.6;
  pose.T_camera_part.linear() =
      (Eigen::AngleAxisd(x_deg * kRadians, Eigen::Vector3d::UnitX()) *
       Eigen::AngleAxisd(y_deg * kRadians, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(face == Face::kFront ? EIGEN_PI : 0.0, Eigen::Vector3d::UnitX()) *
       Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  pose.covariance.diagonal() << 1e-8, 1e-8, 1e-6, 1, 1, 1e-6;
  pose.covariance.diagonal().segment<2>(3).setConstant(std::pow(sigma_deg * kRadians, 2));
  return pose;
}

double tiltBetween(const RefinedPose& a, const RefinedPose& b) {
  return std::acos(std::min(
             1.0, std::abs(a.T_camera_part.linear().col(2).dot(b.T_camera_part.linear().col(2))))) /
         kRadians;
}

/// Poses about (10, -5) degrees that scatter by `spread_deg`, faces mixed, well measured.
std::vector<RefinedPose> lying(double spread_deg, int count) {
  std::mt19937 random(3);
  std::normal_distribution<double> scatter(0.0, spread_deg);
  std::vector<RefinedPose> out;
  for (int i = 0; i < count; ++i) {
    const double x = 10.0 + scatter(random), y = -5.0 + scatter(random);
    out.push_back(poseAt(i % 2 == 0 ? Face::kFront : Face::kBack, x, y, 0.1));
  }
  return out;
}

TEST(CommonLie, FewPosesTellNothing) { EXPECT_FALSE(commonLie(lying(1.0, 5), kParts)); }

TEST(CommonLie, FindsNormalAndSpreadOfBothFaces) {
  auto poses = lying(2.0, 60);
  for (int i = 0; i < 8; ++i) poses.push_back(poseAt(Face::kFront, -40.0, 5.0 * i, 0.1));
  const auto lie = commonLie(poses, kParts);
  ASSERT_TRUE(lie);
  const Eigen::Vector3d expected =
      -poseAt(Face::kBack, 10.0, -5.0, 0.1).T_camera_part.linear().col(2);
  EXPECT_LT(std::acos(lie->normal_camera.dot(expected)), 1.0 * kRadians);
  EXPECT_NEAR(lie->tilt_spread, 2.0 * kRadians, 0.7 * kRadians);
}

TEST(CommonLie, OpenTiltsGoToTheCommonOneAndKnownOnesStay) {
  auto poses = lying(1.0, 40);
  const auto lie = commonLie(poses, kParts);
  ASSERT_TRUE(lie);
  for (const Face face : {Face::kFront, Face::kBack}) {
    const RefinedPose common = poseAt(face, 10.0, -5.0, 0.1);
    std::vector<RefinedPose> fused = {poseAt(face, 14.0, -5.0, 4.0), poseAt(face, 14.0, -5.0, 0.1),
                                      poseAt(face, 40.0, -5.0, 4.0)};
    const auto before = fused;
    fuseWithCommonLie(*lie, kParts, &fused);
    EXPECT_LT(tiltBetween(fused[0], common), 1.0);     // open
    EXPECT_LT(tiltBetween(fused[1], before[1]), 0.2);  // known
    EXPECT_LT(tiltBetween(fused[2], before[2]), 4.0);  // lies otherwise
    EXPECT_LT(fused[0].covariance(3, 3), 0.2 * before[0].covariance(3, 3));
  }
}

TEST(CommonLie, TheFaceTurnsAboutItsCentre) {
  const auto lie = commonLie(lying(1.0, 40), kParts);
  std::vector<RefinedPose> fused = {poseAt(Face::kBack, 14.0, -5.0, 4.0)};
  const Eigen::Vector3d centre(kParts[0]->center().x(), kParts[0]->center().y(),
                               kParts[0]->faceZ(Face::kBack));
  const Eigen::Vector3d before = fused[0].T_camera_part * centre;
  fuseWithCommonLie(*lie, kParts, &fused);
  const Eigen::Vector3d moved = fused[0].T_camera_part * centre - before;
  EXPECT_LT((moved - moved.dot(lie->normal_camera) * lie->normal_camera).norm(), 1e-5);
}

TEST(CommonLie, CorrelatedDepthFollowsTheTilt) {
  auto lie = commonLie(lying(1.0, 40), kParts);
  lie->height_spread = 0.1;  // tells nothing of the depth
  std::vector<RefinedPose> fused = {poseAt(Face::kBack, 14.0, -5.0, 4.0)};
  Matrix6d& C = fused[0].covariance;
  C(2, 3) = C(3, 2) = 0.9 * std::sqrt(C(2, 2) * C(3, 3));
  const double depth = fused[0].T_camera_part.translation().z(), variance = C(2, 2);
  fuseWithCommonLie(*lie, kParts, &fused);
  EXPECT_GT(std::abs(fused[0].T_camera_part.translation().z() - depth), 0.2e-3);
  EXPECT_LT(fused[0].covariance(2, 2), 0.5 * variance);
}

/// Lying flat `height_mm` off a plane 0.6 m away, depth measured to `sigma_mm`.
RefinedPose poseAbove(Face face, double height_mm, double sigma_mm) {
  RefinedPose pose = poseAt(face, 0.0, 0.0, 0.1);
  pose.T_camera_part.translation().z() +=
      0.6 - height_mm * 1e-3 - kParts[0]->thickness() -
      (pose.T_camera_part * centreOf(*kParts[0], face)).translation().z();
  pose.covariance(2, 2) = std::pow(sigma_mm * 1e-3, 2);
  return pose;
}

double heightOf(const RefinedPose& pose) {
  return 1e3 * (0.6 - kParts[0]->thickness() -
                (pose.T_camera_part * centreOf(*kParts[0], pose.face)).translation().z());
}

std::vector<RefinedPose> above(double spread_mm) {
  std::mt19937 random(5);
  std::normal_distribution<double> scatter(0.0, spread_mm);
  std::vector<RefinedPose> out;
  for (int i = 0; i < 40; ++i) {
    out.push_back(poseAbove(i % 2 == 0 ? Face::kFront : Face::kBack, scatter(random), 0.05));
  }
  return out;
}

TEST(CommonLie, InALayerAnOpenDepthGoesToTheOthers) {
  const auto lie = commonLie(above(0.3), kParts);
  ASSERT_TRUE(lie);
  EXPECT_NEAR(lie->height, -0.6, 0.2e-3);
  EXPECT_NEAR(lie->height_spread, 0.3e-3, 0.15e-3);
  for (const Face face : {Face::kFront, Face::kBack}) {
    std::vector<RefinedPose> fused = {poseAbove(face, 4.0, 3.0), poseAbove(face, 4.0, 0.05),
                                      poseAbove(face, 30.0, 3.0)};
    fuseWithCommonLie(*lie, kParts, &fused);
    EXPECT_NEAR(heightOf(fused[0]), 0.0, 0.3);   // open
    EXPECT_NEAR(heightOf(fused[1]), 4.0, 0.1);   // known
    EXPECT_NEAR(heightOf(fused[2]), 30.0, 1.0);  // lies on others
    EXPECT_LT(fused[0].covariance(2, 2), std::pow(0.5e-3, 2));
  }
}

TEST(CommonLie, InAHeapDepthStays) {
  const auto lie = commonLie(above(20.0), kParts);
  ASSERT_TRUE(lie);
  std::vector<RefinedPose> fused = {poseAbove(Face::kFront, 15.0, 1.0)};
  fuseWithCommonLie(*lie, kParts, &fused);
  EXPECT_NEAR(heightOf(fused[0]), 15.0, 0.2);
}

}  // namespace
}  // namespace planar_bin_picking
