// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/model_error.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Of the given camera those of plumb_bob are tested: k4 k5 k6 do nearly what k1 k2 k3 do.
constexpr Eigen::Index kTested = kDenominator;
using CameraVector = Eigen::Matrix<double, kTested, 1>;
using CameraMatrix = Eigen::Matrix<double, kTested, kTested>;

/// Squared scores of the views at columns [from, from + size), over what independent corners give.
double scatter(const Normals& normals, const Eigen::MatrixXd& C, Eigen::Index from,
               Eigen::Index size) {
  const Eigen::MatrixXd weight =
      C.block(from, from, size, size).ldlt().solve(Eigen::MatrixXd::Identity(size, size));
  double seen = 0.0, expected = 0.0;
  for (const Normal& normal : normals.views) {
    const Eigen::VectorXd moved = C.middleRows(from, size) * normal.score;
    seen += moved.dot(weight * moved);
    // The solution has followed each view's score a part of the way: hence the second term.
    const Eigen::MatrixXd H = normal.marginal();
    const Eigen::MatrixXd spread = C * (H - H * C * H) * C;
    expected += (weight * spread.block(from, from, size, size)).trace();
  }
  return expected > 0.0 ? seen / expected : 1.0;
}

/// What moves the corner of the image by a pixel, each of the intrinsics by itself.
CameraVector pixelSteps(const HandEyeProblem& problem, const Chain& chain) {
  const double f = chain.intrinsics[0];
  const double r = 0.5 * std::hypot(problem.width, problem.height) / f, r3 = r * r * r;
  CameraVector steps;
  steps << 1.0 / r, 1.0 / r, 1.0, 1.0, 1.0 / (f * r3), 1.0 / (f * r3 * r * r),
      1.0 / (3.0 * f * r * r), 1.0 / (3.0 * f * r * r), 1.0 / (f * r3 * r3 * r);
  return steps;
}

/// Mean square of an error with this information and score, in steps of one common size, which
/// follows from the score by MacKay's rule.
CameraMatrix meanSquare(const CameraMatrix& information, const CameraVector& score) {
  constexpr int kRounds = 100;
  double variance = 1.0;
  CameraMatrix posterior;
  CameraVector error;
  for (int round = 0; round < kRounds; ++round) {
    CameraMatrix regular = information;
    regular.diagonal().array() += 1.0 / variance;
    posterior = regular.ldlt().solve(CameraMatrix::Identity());
    error = posterior * score;
    const double determined = std::max(0.5, kTested - posterior.trace() / variance);
    variance = std::max(1e-12, error.squaredNorm() / determined);
  }
  return posterior + error * error.transpose();
}

}  // namespace

void scaleByScoreScatter(const Normals& normals, const AdjustOptions& options, Adjusted* state) {
  // A handful of views may scatter little by chance.
  constexpr double kLeastVariance = 0.6;
  Eigen::VectorXd widths = Eigen::VectorXd::Ones(kColumns);
  const std::vector<Eigen::Index> columns = estimatedColumns(options);
  const Eigen::Index starts[] = {kIntrinsics, kHandEye, kHandEye + 3, kBoard,
                                 kBoard + 3,  kScale,   kColumns};
  for (std::size_t i = 0; i + 1 < std::size(starts); ++i) {
    const Eigen::Index from = starts[i];
    // Those of the block that are estimated; they are its first ones.
    const Eigen::Index size = std::count_if(columns.begin(), columns.end(), [&](Eigen::Index k) {
      return k >= from && k < starts[i + 1];
    });
    if (size == 0) continue;
    const double seen = scatter(normals, state->covariance, from, size);
    // One view more, which scatters as expected: few views do not say much either way.
    const auto count = static_cast<double>(normals.views.size());
    const double variance = (count * seen + 1.0) / (count + 1.0);
    widths.segment(from, size).setConstant(std::sqrt(std::max(kLeastVariance, variance)));
  }
  state->covariance = (widths.asDiagonal() * state->covariance * widths.asDiagonal()).eval();
}

void widenByGivenCamera(const HandEyeProblem& problem, const Normals& normals, Adjusted* state) {
  // Of nine normal coordinates the sum of squares is greater in one case of a hundred.
  constexpr double kByChance = 21.67;
  constexpr Eigen::Index kOthers = kSharedSize - kHandEye;
  SharedMatrix H = SharedMatrix::Zero();
  Eigen::Matrix<double, kSharedSize, 1> score = Eigen::Matrix<double, kSharedSize, 1>::Zero();
  for (const Normal& normal : normals.views) {
    H += normal.marginal().topLeftCorner<kSharedSize, kSharedSize>();
    score += normal.score.head<kSharedSize>();
  }
  // Without the rows and columns of k4 k5 k6.
  constexpr Eigen::Index kAll = kTested + kOthers;
  Eigen::Matrix<double, kSharedSize, kAll> keep = Eigen::Matrix<double, kSharedSize, kAll>::Zero();
  keep.topLeftCorner<kTested, kTested>().setIdentity();
  keep.bottomRightCorner<kOthers, kOthers>().setIdentity();
  const Eigen::Matrix<double, kAll, kAll> information_all = keep.transpose() * H * keep;
  // What all else does when the camera changes, and what is left of the information on the camera.
  const Eigen::Matrix<double, kOthers, kTested> others_by_camera =
      -information_all.bottomRightCorner<kOthers, kOthers>().ldlt().solve(
          information_all.bottomLeftCorner<kOthers, kTested>());
  const CameraVector pixel_steps = pixelSteps(problem, state->chain);
  const auto steps = pixel_steps.asDiagonal();
  const CameraMatrix information =
      steps *
      (information_all.topLeftCorner<kTested, kTested>() +
       information_all.topRightCorner<kTested, kOthers>() * others_by_camera) *
      steps;
  const CameraVector own_score =
      steps * (score.head<kTested>() + others_by_camera.transpose() * score.tail<kOthers>());
  const double model_error = own_score.dot(information.ldlt().solve(own_score));
  if (!(model_error > kByChance)) return;
  state->camera_model_error = model_error;
  const CameraMatrix error = steps * meanSquare(information, own_score) * steps;
  Eigen::Matrix<double, kAll, kTested> by_camera;
  by_camera << CameraMatrix::Identity(), others_by_camera;
  state->covariance.topLeftCorner<kSharedSize, kSharedSize>() +=
      keep * by_camera * error * by_camera.transpose() * keep.transpose();
}

}  // namespace planar_bin_picking
