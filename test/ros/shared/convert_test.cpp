// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/convert.h"

#include "planar_bin_picking/image/camera.h"

#include "shared/refusal.h"
#include "support/matchers.h"

#include <gtest/gtest.h>
#include <planar_bin_picking/LocatePart.h>
#include <sensor_msgs/fill_image.h>
#include <sensor_msgs/image_encodings.h>

#include <random>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::Camera;
using planar_bin_picking::Detection;
using planar_bin_picking::Face;
using planar_bin_picking::FaceFilter;
using planar_bin_picking::isometryNear;
using planar_bin_picking::Matrix6d;
using planar_bin_picking::PartFile;
using planar_bin_picking::PartModel;
using planar_bin_picking::Vector6d;

Eigen::Isometry3d exp(const Vector6d& xi) {
  const double angle = xi.tail<3>().norm();
  return Eigen::Translation3d(xi.head<3>()) *
         Eigen::AngleAxisd(angle, angle > 0.0 ? Eigen::Vector3d(xi.tail<3>() / angle)
                                              : Eigen::Vector3d(Eigen::Vector3d::UnitX()));
}

Eigen::Isometry3d somePose() {
  return Eigen::Translation3d(0.1, -0.2, 0.9) *
         Eigen::AngleAxisd(2.6, Eigen::Vector3d(0.8, 0.5, -0.3).normalized());
}

PartModel square(const double thickness) {
  PartFile file;
  file.name = "square";
  file.thickness = thickness;
  planar_bin_picking::Loop loop;
  loop.points = {{0.0, 0.0}, {0.06, 0.0}, {0.06, 0.04}, {0.0, 0.04}};
  file.drawing.loops = {loop};
  planar_bin_picking::PickPose any, back;
  any.name = "any";
  any.T_part_pick.translation() = Eigen::Vector3d(0.03, 0.02, 0.0);
  back.name = "back";
  back.face = FaceFilter::kBack;
  file.pick_poses = {back, any};
  for (auto& pick : file.pick_poses) pick.symmetric = false;  // pick_poses_test has copies
  return PartModel(file);
}

TEST(Convert, PoseRoundTrip) {
  EXPECT_TRUE(isometryNear(fromMsg(toPoseMsg(somePose())), somePose(), 1e-12, 1e-7));
  EXPECT_TRUE(isometryNear(fromMsg(toTransformMsg(somePose())), somePose(), 1e-12, 1e-7));
}

TEST(Convert, RoundedQuaternionGivesRotation) {
  geometry_msgs::Transform rounded;
  rounded.rotation.z = rounded.rotation.w = 0.707;
  const Eigen::Matrix3d R = fromMsg(rounded).linear();
  EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
}

// The claim of the message's definition, checked without its algebra: draw poses as the core means
// its covariance, and measure their spread as ROS means it.
TEST(Convert, CovarianceMatchesSamples) {
  const Eigen::Isometry3d T_header_part = somePose();
  const Eigen::Vector3d center(0.06, 0.04, -0.003);
  Matrix6d root = Matrix6d::Zero();
  root.diagonal() << 1e-4, 2e-4, 9e-4, 4e-3, 2e-3, 1e-3;
  root(5, 0) = 5e-4;  // a correlation, so that the order of the blocks matters
  const Matrix6d covariance = root * root.transpose();

  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Matrix6d measured = Matrix6d::Zero();
  constexpr int kSamples = 100000;
  for (int i = 0; i < kSamples; ++i) {
    Vector6d unit;
    for (double& value : unit) value = normal(random);
    const Eigen::Isometry3d sample = T_header_part * Eigen::Translation3d(center) *
                                     exp(root * unit) * Eigen::Translation3d(-center);
    const Eigen::AngleAxisd turn(sample.linear() * T_header_part.linear().transpose());
    Vector6d error;
    error << sample.translation() - T_header_part.translation(), turn.angle() * turn.axis();
    measured += error * error.transpose() / kSamples;
  }
  const Matrix6d converted = fixedAxesCovariance(covariance, T_header_part.linear(), center);
  const Vector6d sigma = converted.diagonal().cwiseSqrt();
  const Matrix6d scale = sigma * sigma.transpose();
  // 1e5 samples know a variance to sqrt(2 / 1e5) = 0.5 %; five of these, and second-order terms.
  EXPECT_LT((measured - converted).cwiseQuotient(scale).cwiseAbs().maxCoeff(), 0.03);
}

TEST(Convert, DetectionBecomesMessageInHeaderFrame) {
  const PartModel part = square(0.003);
  Detection detection;
  detection.face = Face::kFront;
  detection.T_camera_part = somePose();
  detection.score = 0.9;
  detection.visible_fraction = 0.8;
  detection.covariance = Matrix6d::Identity() * 1e-8;
  const Eigen::Isometry3d T_base_camera =
      Eigen::Translation3d(1.0, 2.0, 3.0) * Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX());
  const auto message = toMsg(detection, part, T_base_camera);
  EXPECT_TRUE(isometryNear(fromMsg(message.pose.pose), T_base_camera * somePose(), 1e-9, 1e-7));
  EXPECT_EQ(message.face, planar_bin_picking::LocatedPart::FRONT);
  EXPECT_EQ(message.part, "square");
  EXPECT_GT(message.pose.covariance[0], 0.99e-8);
  ASSERT_EQ(message.picks.size(), 1u);  // the other one needs the back to be up
  EXPECT_EQ(message.picks[0].name, "any");
  EXPECT_TRUE(isometryNear(fromMsg(message.picks[0].pose),
                           T_base_camera * somePose() * part.file().pick_poses[1].T_part_pick, 1e-9,
                           1e-7));
}

TEST(Convert, PicksKeepTheirOrder) {
  Detection detection;
  detection.face = Face::kBack;
  const auto message = toMsg(detection, square(0.0), Eigen::Isometry3d::Identity());
  ASSERT_EQ(message.picks.size(), 2u);
  EXPECT_EQ(message.picks[0].name, "back");
}

}  // namespace
}  // namespace planar_bin_picking_ros
