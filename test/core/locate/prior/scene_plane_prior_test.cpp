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

std::optional<ScenePlane> planeOf(const std::vector<RefinedPose>& poses) {
  return SceneFaces(poses, kParts).plane();
}

/// The pose with the plane of the others as its prior.
RefinedPose fusedAmong(const RefinedPose& pose, std::vector<RefinedPose> others) {
  others.push_back(pose);
  fuseWithScenePlane(kParts, &others);
  return others.back();
}

TEST(ScenePlane, FewPosesTellNothing) {
  EXPECT_FALSE(planeOf(lying(1.0, 4)));
  EXPECT_TRUE(planeOf(lying(1.0, 5)));
  const RefinedPose pose = poseAt(Face::kFront, 14.0, -5.0, 4.0);
  EXPECT_EQ(fusedAmong(pose, lying(1.0, 4)).T_camera_part.matrix(), pose.T_camera_part.matrix());
  EXPECT_LT(fusedAmong(pose, lying(1.0, 5)).covariance(3, 3), 0.5 * pose.covariance(3, 3));
}

TEST(ScenePlane, FindsNormalAndSpreadOfBothFaces) {
  auto poses = lying(2.0, 60);
  for (int i = 0; i < 8; ++i) poses.push_back(poseAt(Face::kFront, -40.0, 5.0 * i, 0.1));
  const auto scene = planeOf(poses);
  ASSERT_TRUE(scene);
  const Eigen::Vector3d expected =
      -poseAt(Face::kBack, 10.0, -5.0, 0.1).T_camera_part.linear().col(2);
  EXPECT_LT(std::acos(scene->plane.normal_camera.dot(expected)), 1.0 * kRadians);
  EXPECT_NEAR(scene->tilt_spread, 2.0 * kRadians, 0.7 * kRadians);
}

TEST(ScenePlane, APoseIsLeftOutOfItsOwnPrior) {
  auto poses = lying(1.0, 8);
  const SceneFaces faces(poses, kParts);
  const auto others = faces.plane(3);
  poses.erase(poses.begin() + 3);
  const auto without = planeOf(poses);
  ASSERT_TRUE(others && without);
  EXPECT_EQ(others->plane.normal_camera, without->plane.normal_camera);
  EXPECT_EQ(others->plane.distance, without->plane.distance);
  EXPECT_EQ(others->tilt_spread, without->tilt_spread);
  EXPECT_NE(others->plane.normal_camera, faces.plane()->plane.normal_camera);
}

TEST(ScenePlane, OpenTiltsFollowTheSceneAndKnownOnesStay) {
  const auto others = lying(1.0, 40);
  for (const Face face : {Face::kFront, Face::kBack}) {
    const RefinedPose common = poseAt(face, 10.0, -5.0, 0.1);
    const RefinedPose open = poseAt(face, 14.0, -5.0, 4.0), known = poseAt(face, 14.0, -5.0, 0.1),
                      otherwise = poseAt(face, 40.0, -5.0, 4.0);
    EXPECT_LT(tiltBetween(fusedAmong(open, others), common), 1.0);
    EXPECT_LT(tiltBetween(fusedAmong(known, others), known), 0.2);
    EXPECT_LT(tiltBetween(fusedAmong(otherwise, others), otherwise), 4.0);
    EXPECT_LT(fusedAmong(open, others).covariance(3, 3), 0.2 * open.covariance(3, 3));
  }
}

TEST(ScenePlane, TheFaceTurnsAboutItsCentre) {
  const RefinedPose pose = poseAt(Face::kBack, 14.0, -5.0, 4.0);
  const auto others = lying(1.0, 40);
  const Eigen::Vector3d centre(kParts[0]->center().x(), kParts[0]->center().y(),
                               kParts[0]->faceZ(Face::kBack));
  const Eigen::Vector3d moved =
      fusedAmong(pose, others).T_camera_part * centre - pose.T_camera_part * centre;
  const Eigen::Vector3d n = planeOf(others)->plane.normal_camera;
  EXPECT_LT((moved - moved.dot(n) * n).norm(), 1e-5);
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

TEST(ScenePlane, InALayerAnOpenDepthGoesToTheOthers) {
  const auto others = above(0.3);
  const auto scene = planeOf(others);
  ASSERT_TRUE(scene);
  EXPECT_NEAR(scene->plane.distance, 0.6, 0.2e-3);
  EXPECT_NEAR(scene->height_spread, 0.3e-3, 0.15e-3);
  for (const Face face : {Face::kFront, Face::kBack}) {
    const RefinedPose open = fusedAmong(poseAbove(face, 4.0, 3.0), others);
    EXPECT_NEAR(heightOf(open), 0.0, 0.3);
    EXPECT_LT(open.covariance(2, 2), std::pow(0.5e-3, 2));
    EXPECT_NEAR(heightOf(fusedAmong(poseAbove(face, 4.0, 0.05), others)), 4.0, 0.1);   // known
    EXPECT_NEAR(heightOf(fusedAmong(poseAbove(face, 30.0, 3.0), others)), 30.0, 1.0);  // on others
  }
}

TEST(ScenePlane, IsThatOfTheUndersidesWhateverTheThickness) {
  sim::Plate thick = bracketPlate();
  thick.thickness_mm += 20.0;
  const std::vector<std::shared_ptr<const PartModel>> parts = {kParts[0], makePart("thick", thick)};
  std::vector<RefinedPose> poses;
  for (int i = 0; i < 12; ++i) {
    poses.push_back(poseAbove(i % 4 < 2 ? Face::kFront : Face::kBack, 0.0, 0.1));
    RefinedPose& pose = poses.back();
    if (i % 2 == 0) continue;
    pose.part = 1;
    const double z = (pose.T_camera_part * centreOf(*parts[1], pose.face)).translation().z();
    pose.T_camera_part.translation().z() += 0.6 - parts[1]->thickness() - z;
  }
  const auto scene = SceneFaces(poses, parts).plane();
  ASSERT_TRUE(scene);
  EXPECT_NEAR(scene->plane.distance, 0.6, 1e-6);
  EXPECT_LT(scene->height_spread, 0.3e-3);
}

TEST(ScenePlane, CorrelatedDepthFollowsTheTilt) {
  std::vector<RefinedPose> others = lying(1.0, 40);
  for (std::size_t i = 0; i < others.size(); ++i)  // a heap: it tells nothing of the depth
    others[i].T_camera_part.translation().z() += 0.01 * static_cast<double>(i);
  RefinedPose pose = poseAt(Face::kBack, 14.0, -5.0, 4.0);
  pose.T_camera_part.translation().z() += 0.2;
  Matrix6d& C = pose.covariance;
  C(2, 3) = C(3, 2) = 0.9 * std::sqrt(C(2, 2) * C(3, 3));
  const RefinedPose fused = fusedAmong(pose, others);
  EXPECT_GT(std::abs((fused.T_camera_part.translation() - pose.T_camera_part.translation()).z()),
            0.2e-3);
  EXPECT_LT(fused.covariance(2, 2), 0.5 * C(2, 2));
}

TEST(ScenePlane, InAHeapDepthStays) {
  const RefinedPose fused = fusedAmong(poseAbove(Face::kFront, 15.0, 1.0), above(20.0));
  EXPECT_NEAR(heightOf(fused), 15.0, 0.2);
}

}  // namespace
}  // namespace planar_bin_picking
