// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What is known besides the image, and how it is joined with what the image says. The known plane,
/// the plane that the scene's parts lie on and the edge offset of one copy all go this way.

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace planar_bin_picking {

/// residual + jacobian * x is zero, up to an error with this covariance.
template <int N, int M>
struct LinearPrior {
  Eigen::Matrix<double, M, N> jacobian;
  Eigen::Matrix<double, M, 1> residual;
  Eigen::Matrix<double, M, M> covariance;
};

/// A Gaussian of the state x.
template <int N>
struct Estimate {
  Eigen::Matrix<double, N, 1> mean = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> covariance = Eigen::Matrix<double, N, N>::Zero();
};

/// The Kalman update of the estimate by the prior: both together, each by its covariance. Cost:
/// O(N^2 M).
template <int N, int M>
Estimate<N> fuse(const Estimate<N>& estimate, const LinearPrior<N, M>& prior) {
  const auto& J = prior.jacobian;
  const Eigen::Matrix<double, M, N> JC = J * estimate.covariance;
  const Eigen::Matrix<double, M, M> innovation = JC * J.transpose() + prior.covariance;
  const Eigen::Matrix<double, N, M> gain = innovation.ldlt().solve(JC).transpose();
  Estimate<N> out;
  out.mean = estimate.mean - gain * (prior.residual + J * estimate.mean);
  const Eigen::Matrix<double, N, N> left = estimate.covariance - gain * JC;
  out.covariance = 0.5 * (left + left.transpose());
  return out;
}

}  // namespace planar_bin_picking
