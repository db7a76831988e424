// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/flat_face.h"

#include "part/outline_view.h"
#include "planar_bin_picking/base/se3.h"
#include "support/plates.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

const auto kBracket = [] {
  sim::Plate plate = bracketPlate();
  plate.thickness_mm = 4.0;
  return makePart("bracket", plate);
}();

Eigen::Isometry3d facing(double x_deg, double y_deg) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.02, -0.03, 0.6;
  T.linear() = (Eigen::AngleAxisd(x_deg * kDegrees, Eigen::Vector3d::UnitX()) *
                Eigen::AngleAxisd(y_deg * kDegrees, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()) *
                Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()))
                   .toRotationMatrix();
  return T;
}

const Plane kPlane{Eigen::Vector3d(0.1, -0.05, -1.0).normalized(), 0.62};

TEST(FlatFace, TheJacobianIsTheDerivative) {
  const Eigen::Isometry3d T = facing(8.0, -12.0);
  const auto prior = flatOn(kPlane, T, 0.004, {1.0, 1.0, 1.0});
  const Eigen::Vector3d variances(1.0, 4.0, 9.0);
  const Eigen::Matrix3d covariance = variances.asDiagonal();
  EXPECT_EQ(flatOn(kPlane, T, 0.004, variances).covariance, covariance);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    Vector6d xi = Vector6d::Zero();
    xi(k) = kStep;
    const Eigen::Vector3d up = flatOn(kPlane, T * exp(xi), 0.004, {1.0, 1.0, 1.0}).residual;
    xi(k) = -kStep;
    const Eigen::Vector3d down = flatOn(kPlane, T * exp(xi), 0.004, {1.0, 1.0, 1.0}).residual;
    EXPECT_LT((prior.jacobian.col(k) - (up - down) / (2.0 * kStep)).norm(), 1e-8) << k;
  }
}

/// From far off: an exact prior puts the face on the plane, whatever is in the way of a single
/// step.
TEST(FlatFace, AnExactPriorLaysThePartFlat) {
  for (const Face face : {Face::kFront, Face::kBack}) {
    RefinedPose pose;
    pose.face = face;
    pose.T_camera_part = facing(9.0, -11.0);
    if (face == Face::kBack)
      pose.T_camera_part =
          pose.T_camera_part * Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX());
    pose.covariance.diagonal() << 1e-8, 1e-8, 1e-4, 1e-2, 1e-2, 1e-6;
    const RefinedPose fused = fuseFlat(pose, *kBracket, kPlane, {1e-14, 1e-14, 1e-14});
    const auto left = flatOn(kPlane, fused.T_camera_part * centreOf(*kBracket, face),
                             kBracket->thickness(), {1.0, 1.0, 1.0});
    EXPECT_LT(std::abs(left.residual(0)), 1e-6);
    EXPECT_LT(left.residual.tail<2>().norm(), 1e-5);
    EXPECT_EQ(fused.face, face);
    // The visible face lies one thickness over the plane, looks along its normal, and nothing is
    // left open of height and tilt.
    const Eigen::Vector3d centre = fused.T_camera_part * centreOf(*kBracket, face).translation();
    EXPECT_NEAR(kPlane.normal_camera.dot(centre) + kPlane.distance, kBracket->thickness(), 1e-6);
    const double along = fused.T_camera_part.linear().col(2).dot(kPlane.normal_camera);
    EXPECT_NEAR(along, face == Face::kFront ? 1.0 : -1.0, 1e-9);
    for (const int k : {2, 3, 4}) EXPECT_LT(fused.covariance(k, k), 1e-12) << k;
    EXPECT_NEAR(fused.covariance(5, 5), 1e-6, 1e-8);
  }
}

}  // namespace
}  // namespace planar_bin_picking
