// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/prior/plane_prior.h"

#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/locate/locator.h"
#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;

sim::Plate thickPlate() {
  sim::Plate plate = bracketPlate();
  plate.thickness_mm = 3.0;
  return plate;
}

const Parts kParts = {makePart("bracket", thickPlate())};

/// A belt 0.6 m below a camera that leans by 10 degrees.
Plane leaningBelt() {
  return {Eigen::AngleAxisd(10.0 * kDegrees, Eigen::Vector3d::UnitX()) * -Eigen::Vector3d::UnitZ(),
          0.6};
}

/// A part that lies flat on the belt, turned about the belt's normal, its middle at (x, y) of it.
Eigen::Isometry3d lyingOn(const Plane& plane, const PartModel& part, Face face, double x, double y,
                          double turn) {
  const bool front = face == Face::kFront;
  Eigen::Matrix3d R_camera_belt =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), plane.normal_camera)
          .toRotationMatrix();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R_camera_belt * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) *
               Eigen::AngleAxisd(front ? 0.0 : kPi, Eigen::Vector3d::UnitX());
  const Eigen::Vector3d seen = -plane.distance * plane.normal_camera +
                               R_camera_belt * Eigen::Vector3d(x, y, part.thickness());
  const Eigen::Vector3d center(part.center().x(), part.center().y(), part.faceZ(face));
  T.translation() = seen - T.linear() * center;
  return T;
}

/// As a picture would give it: good sideways, bad in depth and tilt.
RefinedPose foundNear(const Eigen::Isometry3d& T_camera_part, Face face, const Vector6d& error) {
  const Eigen::Isometry3d T_part_face(Eigen::Translation3d(
      kParts[0]->center().x(), kParts[0]->center().y(), kParts[0]->faceZ(face)));
  RefinedPose pose;
  pose.face = face;
  pose.T_camera_part = T_camera_part * T_part_face * exp(error) * T_part_face.inverse();
  Vector6d sigmas;
  sigmas << 5e-5, 5e-5, 2e-3, 0.02, 0.02, 1e-3;
  pose.covariance = sigmas.cwiseAbs2().asDiagonal();
  return pose;
}

Vector6d vector6(double x, double y, double z, double rx, double ry, double rz) {
  return (Vector6d() << x, y, z, rx, ry, rz).finished();
}

TEST(PlanePrior, IsOffByDefault) {
  EXPECT_FALSE(planeOf({}));
  PlaneParams params;
  params.distance = 0.8;
  params.normal_x = 0.3, params.normal_z = -0.4;
  const auto plane = planeOf(params);
  ASSERT_TRUE(plane);
  EXPECT_TRUE(plane->normal_camera.isApprox(Eigen::Vector3d(0.6, 0.0, -0.8)));
  EXPECT_EQ(plane->distance, 0.8);
}

TEST(PlanePrior, SharpensDepthAndTiltOfBothFaces) {
  const Plane plane = leaningBelt();
  for (const Face face : {Face::kFront, Face::kBack}) {
    const auto truth = lyingOn(plane, *kParts[0], face, 0.07, -0.04, 0.8);
    const RefinedPose found = foundNear(truth, face, vector6(0, 0, 2.5e-3, 0.02, -0.025, 0));
    const auto fused = fuseWithPlane(found, *kParts[0], plane, {});
    ASSERT_TRUE(fused);
    EXPECT_FALSE(isometryNear(found.T_camera_part, truth, 1e-3, 1.0 * kDegrees));
    EXPECT_TRUE(isometryNear(fused->T_camera_part, truth, 0.2e-3, 0.1 * kDegrees));
    // A measurement's weight: no worse than the plane, and than the picture.
    EXPECT_LT(std::sqrt(fused->covariance(2, 2)), PlaneParams().sigma);
    EXPECT_LT(std::sqrt(fused->covariance(3, 3)), PlaneParams().sigma_tilt_deg * kDegrees);
    EXPECT_NEAR(fused->covariance(0, 0), found.covariance(0, 0), 1e-12);
    EXPECT_TRUE(fused->covariance.isApprox(fused->covariance.transpose()));
  }
}

TEST(PlanePrior, TellsTwoTiltsApart) {
  const Plane plane = leaningBelt();
  const auto truth = lyingOn(plane, *kParts[0], Face::kFront, 0.07, -0.04, 0.8);
  RefinedPose found = foundNear(truth, Face::kFront, vector6(0, 0, 1e-3, 0.01, 0, 0));
  found.other_tilt = vector6(0, 0, 0, 0.1, 0, 0);
  EXPECT_TRUE(fuseWithPlane(found, *kParts[0], plane, {}).value().other_tilt.isZero(0.0));
}

TEST(PlanePrior, PictureAndPlaneCountByTheirPrecisions) {
  const Plane plane{-Eigen::Vector3d::UnitZ(), 0.6};
  const auto truth = lyingOn(plane, *kParts[0], Face::kFront, 0.0, 0.0, 0.0);
  PlaneParams params;
  params.sigma = 1e-3, params.sigma_tilt_deg = 1.0;
  const double error = 1.5e-3;
  const RefinedPose found = foundNear(truth, Face::kFront, vector6(0, 0, error, 0.01, 0, 0));
  const auto fused = fuseWithPlane(found, *kParts[0], plane, params);
  ASSERT_TRUE(fused);
  const auto together = [](double variance, double sigma) {
    return 1.0 / (1.0 / variance + 1.0 / (sigma * sigma));
  };
  const double depth = together(found.covariance(2, 2), params.sigma);
  const double tilt = together(found.covariance(3, 3), params.sigma_tilt_deg * kDegrees);
  EXPECT_NEAR(fused->covariance(2, 2), depth, 0.01 * depth);
  EXPECT_NEAR(fused->covariance(3, 3), tilt, 0.01 * tilt);
  EXPECT_NEAR(fused->covariance(4, 4), tilt, 0.01 * tilt);
  // What of the errors is left: the picture's share.
  const auto left = foundNear(truth, Face::kFront,
                              vector6(0, 0, error * depth / found.covariance(2, 2),
                                      0.01 * tilt / found.covariance(3, 3), 0, 0));
  EXPECT_TRUE(isometryNear(fused->T_camera_part, left.T_camera_part, 2e-5, 0.01 * kDegrees));
}

TEST(PlanePrior, WhatIsCorrelatedWithDepthChangesToo) {
  const Plane plane{-Eigen::Vector3d::UnitZ(), 0.6};
  const auto truth = lyingOn(plane, *kParts[0], Face::kFront, 0.1, 0.0, 0.0);
  RefinedPose found = foundNear(truth, Face::kFront, vector6(4e-4, 0, 2e-3, 0, 0, 0));
  // Off the picture's middle, an error in depth shows aside: 0.2 of it here.
  found.covariance(0, 0) += 0.04 * found.covariance(2, 2);
  found.covariance(0, 2) = found.covariance(2, 0) = 0.2 * found.covariance(2, 2);
  const auto fused = fuseWithPlane(found, *kParts[0], plane, {});
  ASSERT_TRUE(fused);
  EXPECT_TRUE(isometryNear(fused->T_camera_part, truth, 0.2e-3, 0.05 * kDegrees));
}

TEST(PlanePrior, AVagueOneChangesNothing) {
  const Plane plane = leaningBelt();
  PlaneParams vague;
  vague.sigma = 0.1, vague.sigma_tilt_deg = 45.0;
  const auto truth = lyingOn(plane, *kParts[0], Face::kBack, 0.0, 0.05, 2.0);
  const RefinedPose found = foundNear(truth, Face::kBack, vector6(0, 0, 2e-3, 0.01, -0.01, 0));
  const auto fused = fuseWithPlane(found, *kParts[0], plane, vague);
  ASSERT_TRUE(fused);
  EXPECT_TRUE(isometryNear(fused->T_camera_part, found.T_camera_part, 2e-6, 0.02 * kDegrees));
}

TEST(PlanePrior, DropsWhatLiesOnAnotherPart) {
  const Plane plane = leaningBelt();
  const auto flat = lyingOn(plane, *kParts[0], Face::kFront, 0.0, 0.0, 0.0);
  const auto on = foundNear(flat, Face::kFront, Vector6d::Zero());
  const auto above = foundNear(flat, Face::kFront, vector6(0, 0, 20e-3, 0, 0, 0));
  const auto leaning = foundNear(flat, Face::kFront, vector6(0, 0, 0, 0.2, 0, 0));
  const auto kept = fuseWithPlane({above, on, leaning}, kParts, plane, {});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_TRUE(isometryNear(kept[0].T_camera_part, flat, 1e-6, 1e-3 * kDegrees));
}

/// Pose and plane together: 4 mm by the picture and 3 mm of the plane are 5 mm of both.
TEST(PlanePrior, TheGateCountsSigmasOfBoth) {
  const Plane plane{-Eigen::Vector3d::UnitZ(), 0.6};
  const auto truth = lyingOn(plane, *kParts[0], Face::kFront, 0.0, 0.0, 0.0);
  PlaneParams params;
  params.sigma = 3e-3;
  for (const double gate : {2.0, 4.0}) {
    params.gate = gate;
    const auto keeps = [&](double sigmas) {
      RefinedPose found = foundNear(truth, Face::kFront, vector6(0, 0, sigmas * 5e-3, 0, 0, 0));
      found.covariance(2, 2) = 16e-6;
      return fuseWithPlane(found, *kParts[0], plane, params).has_value();
    };
    EXPECT_TRUE(keeps(0.98 * gate)) << gate;
    EXPECT_TRUE(keeps(-0.98 * gate)) << gate;
    EXPECT_FALSE(keeps(1.02 * gate)) << gate;
    EXPECT_FALSE(keeps(-1.02 * gate)) << gate;
  }
}

TEST(PlanePrior, NarrowsTheDistances) {
  const Camera camera = makeCamera(kPinhole);
  const PlaneParams params;
  const double slack = params.gate * (params.sigma + params.sigma_tilt_deg * kDegrees * 0.6);
  const Plane straight{-Eigen::Vector3d::UnitZ(), 0.6};
  const auto flat = distancesOnPlane(camera, straight, 0.003, {0.4, 0.8}, params);
  ASSERT_TRUE(flat);
  EXPECT_NEAR(flat->min, 0.597 - slack, 1e-9);
  EXPECT_NEAR(flat->max, 0.597 + slack, 1e-9);
  const auto within = distancesOnPlane(camera, straight, 0.003, {0.59, 0.8}, params);
  EXPECT_EQ(within->min, 0.59);
  EXPECT_FALSE(distancesOnPlane(camera, straight, 0.003, {0.3, 0.5}, params));
  // One distance that is left is not outside.
  const auto touching = distancesOnPlane(camera, straight, 0.003, {0.4, flat->min}, params);
  ASSERT_TRUE(touching);
  EXPECT_EQ(touching->min, flat->min);
  EXPECT_EQ(touching->max, flat->min);
  // What a leaning camera sees at the picture's upper and lower edge is nearer and farther.
  const auto lean = distancesOnPlane(camera, leaningBelt(), 0.003, {0.4, 0.8}, params);
  EXPECT_LT(lean->min, flat->min - 0.02);
  EXPECT_GT(lean->max, flat->max + 0.02);
  // Leaning to both sides: any pixel sees the part's face within these distances, and some at their
  // ends.
  const Plane skewed{(leaningBelt().normal_camera + 0.1 * Eigen::Vector3d::UnitX()).normalized(),
                     0.6};
  const auto found = distancesOnPlane(camera, skewed, 0.003, {0.4, 0.8}, params);
  Distances seen{1e9, 0.0};
  for (int x = 0; x < kPinhole.width; ++x) {
    for (const int y : {0, kPinhole.height - 1}) {
      const Eigen::Vector3d ray = camera.undistort(Eigen::Vector2d(x, y)).homogeneous();
      const double per_metre = 1.0 / std::abs(skewed.normal_camera.dot(ray));
      seen.min = std::min(seen.min, (0.597 - slack) * per_metre);
      seen.max = std::max(seen.max, (0.597 + slack) * per_metre);
    }
  }
  EXPECT_NEAR(found->min, seen.min, 1e-9);
  EXPECT_NEAR(found->max, seen.max, 1e-9);
  // A plane that rises to the horizon tells nothing about distances.
  const Plane steep{
      Eigen::AngleAxisd(80 * kDegrees, Eigen::Vector3d::UnitX()) * -Eigen::Vector3d::UnitZ(), 0.6};
  const auto all = distancesOnPlane(camera, steep, 0.003, {0.4, 0.8}, params);
  EXPECT_EQ(all->min, 0.4);
  EXPECT_EQ(all->max, 0.8);
}

TEST(PlanePrior, ThroughTheLocator) {
  const Plane plane{-Eigen::Vector3d::UnitZ(), 0.6 + kParts[0]->thickness()};
  sim::Scene scene;
  scene.plates.push_back({thickPlate(), sim::poseOf({-110, -80, 600, 20})});
  scene.plates.push_back({thickPlate(), sim::poseOf({100, 70, 560, 120})});  // not on the plane
  const cv::Mat image = sim::takeImage(kPinhole, scene);
  const Camera camera = makeCamera(kPinhole);
  LocateRequest request;
  request.parts = kParts;
  request.distance_min = 0.5, request.distance_max = 0.7;
  EXPECT_EQ(Locator().locate(image, camera, request).detections.size(), 2u);
  request.plane = plane;
  const auto result = Locator().locate(image, camera, request);
  ASSERT_EQ(result.detections.size(), 1u);
  EXPECT_TRUE(isometryNear(result.detections[0].T_camera_part, scene.plates[0].T_camera_part,
                           0.3e-3, 0.1 * kDegrees));
  ASSERT_EQ(result.report.stages.size(), 6u);
  EXPECT_EQ(result.report.stages[3].name, "plane");
  request.plane->distance = 0.9;
  EXPECT_TRUE(
      refuses([&] { Locator().locate(image, camera, request); }, {"plane 0.9", "bracket", "0.7"}));
}

TEST(PlanePrior, FromTheParameters) {
  sim::Scene scene;
  scene.plates.push_back({thickPlate(), sim::poseOf({-110, -80, 600, 20})});
  LocatorParams params;
  params.plane.distance = 0.6 + kParts[0]->thickness();
  LocateRequest request;
  request.parts = kParts;
  request.distance_min = 0.5, request.distance_max = 0.7;
  const auto result =
      Locator(params).locate(sim::takeImage(kPinhole, scene), makeCamera(kPinhole), request);
  EXPECT_EQ(result.report.stages.size(), 6u);
  EXPECT_EQ(result.detections.size(), 1u);
}

}  // namespace
}  // namespace planar_bin_picking
