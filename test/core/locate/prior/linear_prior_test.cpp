// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/linear_prior.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

namespace planar_bin_picking {
namespace {

Eigen::Matrix3d spd(double a) {
  Eigen::Matrix3d m;
  m << 4.0, 1.0 * a, 0.5, 1.0 * a, 3.0, -0.7, 0.5, -0.7, 2.0;
  return m;
}

/// The minimum of both squared Mahalanobis distances, by their information.
TEST(LinearPrior, FusionIsTheLeastSquaresOfBoth) {
  Estimate<3> estimate;
  estimate.mean << 1.0, -2.0, 0.5;
  estimate.covariance = spd(1.0);
  LinearPrior<3, 2> prior;
  prior.jacobian << 1.0, 0.5, 0.0, -0.3, 0.0, 2.0;
  prior.residual << 0.7, -0.2;
  prior.covariance << 0.5, 0.1, 0.1, 0.8;
  const Eigen::Matrix3d information =
      estimate.covariance.inverse() +
      prior.jacobian.transpose() * prior.covariance.inverse() * prior.jacobian;
  const Eigen::Vector3d right =
      estimate.covariance.inverse() * estimate.mean -
      prior.jacobian.transpose() * prior.covariance.inverse() * prior.residual;
  const Estimate<3> fused = fuse(estimate, prior);
  EXPECT_TRUE(fused.mean.isApprox(information.inverse() * right, 1e-9));
  EXPECT_TRUE(fused.covariance.isApprox(information.inverse(), 1e-9));
  EXPECT_EQ(fused.covariance, fused.covariance.transpose());
}

TEST(LinearPrior, AVaguePriorChangesNothingAndAnExactOneDecides) {
  Estimate<3> estimate;
  estimate.mean << 1.0, -2.0, 0.5;
  estimate.covariance = spd(-1.0);
  LinearPrior<3, 1> prior;
  prior.jacobian << 0.0, 0.0, 1.0;
  prior.residual << -3.0;
  prior.covariance << 1e12;
  EXPECT_TRUE(fuse(estimate, prior).mean.isApprox(estimate.mean, 1e-6));
  prior.covariance << 0.0;
  const Estimate<3> fused = fuse(estimate, prior);
  EXPECT_NEAR(fused.mean(2), 3.0, 1e-12);
  EXPECT_NEAR(fused.covariance(2, 2), 0.0, 1e-12);
  EXPECT_GT(fused.covariance(0, 0), 1.0);
}

}  // namespace
}  // namespace planar_bin_picking
