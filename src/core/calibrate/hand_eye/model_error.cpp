// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/model_error.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

using CameraVector = Eigen::Matrix<double, kHandEye, 1>;
using CameraMatrix = Eigen::Matrix<double, kHandEye, kHandEye>;

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
    const double determined = std::max(0.5, kHandEye - posterior.trace() / variance);
    variance = std::max(1e-12, error.squaredNorm() / determined);
  }
  return posterior + error * error.transpose();
}

}  // namespace

void widenByScoreScatter(const Normals& normals, const AdjustOptions& options, Adjusted* state) {
  Eigen::VectorXd widths = Eigen::VectorXd::Ones(kColumns);
  const std::vector<Eigen::Index> columns = estimatedColumns(options);
  const Eigen::Index starts[] = {kIntrinsics, kHandEye, kBoard, kScale, kColumns};
  for (std::size_t i = 0; i + 1 < std::size(starts); ++i) {
    const Eigen::Index from = starts[i], size = starts[i + 1] - from;
    if (std::find(columns.begin(), columns.end(), from) == columns.end()) continue;
    // Less scatter than expected is luck: nothing is taken for better than the model has it.
    widths.segment(from, size)
        .setConstant(std::sqrt(std::max(1.0, scatter(normals, state->covariance, from, size))));
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
  // What all else does when the camera changes, and what is left of the information on the camera.
  const Eigen::Matrix<double, kOthers, kHandEye> others_by_camera =
      -H.bottomRightCorner<kOthers, kOthers>().ldlt().solve(
          H.bottomLeftCorner<kOthers, kHandEye>());
  const CameraVector pixel_steps = pixelSteps(problem, state->chain);
  const auto steps = pixel_steps.asDiagonal();
  const CameraMatrix information = steps *
                                   (H.topLeftCorner<kHandEye, kHandEye>() +
                                    H.topRightCorner<kHandEye, kOthers>() * others_by_camera) *
                                   steps;
  const CameraVector own_score =
      steps * (score.head<kHandEye>() + others_by_camera.transpose() * score.tail<kOthers>());
  const double model_error = own_score.dot(information.ldlt().solve(own_score));
  if (!(model_error > kByChance)) return;
  state->camera_model_error = model_error;
  const CameraMatrix error = steps * meanSquare(information, own_score) * steps;
  Eigen::Matrix<double, kSharedSize, kHandEye> by_camera;
  by_camera << CameraMatrix::Identity(), others_by_camera;
  state->covariance.topLeftCorner<kSharedSize, kSharedSize>() +=
      by_camera * error * by_camera.transpose();
}

}  // namespace planar_bin_picking
