// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/probability.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

// Coefficients of the regression, see test/benchmark/README.md.
constexpr double kConstant = -7.46;
constexpr double kEdges = 8.81;
constexpr double kBeyondCorners = -8.8;
constexpr double kHolesSeen = 2.4;
constexpr double kHolesMissing = -1.44;
constexpr double kSlide = -0.89;  // of the natural logarithm

/// Of PoseEvidence::edges: what is better confirmed is right no more often; what is wrong there is
/// a tilt or a depth, which edges hardly tell.
constexpr double kAllEdges = 0.8;
constexpr double kHoles = 0.5;  // above it holes speak for a pose, below it against it
/// Nobody's lens and drawing are better than the lower ones; beyond the upper ones nothing holds
/// the pose.
constexpr double kSlideLeastPx = 0.1, kSlideMostPx = 20.0;
constexpr double kSlideLeastRadii = 3e-4, kSlideMostRadii = 0.3;

constexpr double kTiltRight = 6.0 * EIGEN_PI / 180.0;

/// The largest standard deviation along any direction of the two axes from `first` on.
double largestSigma(const Matrix6d& covariance, int first) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance.block<2, 2>(first, first),
                                                              Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()(1)));
}

/// Logarithm of the geometric mean in pixels and in radii: a small part is held as well in a fine
/// picture as a large one in a coarse one.
double logOfSlide(const PoseEvidence& e) {
  return 0.5 * (std::log(std::clamp(e.slide_px, kSlideLeastPx, kSlideMostPx)) +
                std::log(std::clamp(e.slide_radii, kSlideLeastRadii, kSlideMostRadii)));
}

}  // namespace

double probabilityRight(const PoseEvidence& e) {
  double sum = kConstant + kEdges * std::min(e.edges, kAllEdges) +
               kBeyondCorners * e.beyond_corners.value_or(0.0) + kSlide * logOfSlide(e);
  if (e.holes) {
    sum += kHolesSeen * std::max(0.0, *e.holes - kHoles);
    sum += kHolesMissing * std::max(0.0, kHoles - *e.holes);
  }
  return 1.0 / (1.0 + std::exp(-sum));
}

double probabilityOfTilt(const RefinedPose& pose) {
  return std::erf(kTiltRight / (std::sqrt(2.0) * largestSigma(pose.covariance, 3)));
}

double sigmaInPlane(const RefinedPose& pose) { return largestSigma(pose.covariance, 0); }

}  // namespace planar_bin_picking
