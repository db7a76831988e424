// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/noise_estimate.h"

#include "base/scatter.h"
#include "calibrate/hand_eye/model_error.h"
#include "calibrate/hand_eye/normal_equations.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Beyond so many standard deviations a corner's influence no longer grows (Huber).
constexpr double kHuber = 2.5;

/// Pixel noise from the median distance, and each corner's weight.
void weighCorners(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                  const AdjustOptions& options, Adjusted* state) {
  std::vector<std::vector<double>> distances;
  std::vector<double> all;
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::vector<double>& of_view = distances.emplace_back();
    for (const auto& r : residuals(state->chain, problem.board, *views[i], state->corrections[i])) {
      of_view.push_back(r.norm());
      all.push_back(r.norm());
    }
  }
  const double count = 2.0 * static_cast<double>(all.size());
  const double taken = 6.0 * static_cast<double>(views.size()) +
                       static_cast<double>(estimatedColumns(options).size());
  constexpr double kMedianOfRayleigh = 1.1774;
  // Drawn images have corners without any noise; the floor keeps the weights finite.
  const double sigma = std::max(
      1e-3, median(all) / kMedianOfRayleigh * std::sqrt(count / std::max(1.0, count - taken)));
  state->noise.pixel = sigma;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t k = 0; k < distances[i].size(); ++k) {
      const double share = kHuber * sigma / std::max(1e-12, distances[i][k]);
      state->weights[i][k] = std::min(1.0, share);
    }
  }
}

}  // namespace

void estimateNoise(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                   const AdjustOptions& options, Adjusted* state) {
  weighCorners(problem, views, options, state);
  if (options.fixed_robot_noise) return;
  const auto normals = normalsOf(problem, views, options, *state);
  const auto covariance = normals ? invertInformation(normals->information, options) : std::nullopt;
  state->degenerate = !covariance;
  if (state->degenerate) return;
  double square_t = 0.0, square_r = 0.0, trace_t = 0.0, trace_r = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Normal& normal = normals->views[i];
    const Matrix6d own = normal.correction.inverse();
    const Eigen::MatrixXd gain = own * normal.mixed.transpose();
    const Matrix6d posterior = own + gain * *covariance * gain.transpose();
    trace_t += posterior.topLeftCorner<3, 3>().trace();
    trace_r += posterior.bottomRightCorner<3, 3>().trace();
    square_t += state->corrections[i].head<3>().squaredNorm();
    square_r += state->corrections[i].tail<3>().squaredNorm();
  }
  const double all = 3.0 * static_cast<double>(views.size());
  const auto updated = [all](double square, double trace, double sigma, double lowest) {
    const double determined = std::max(0.5, all - trace / (sigma * sigma));
    return std::max(lowest, std::sqrt(square / determined));
  };
  // Far below what any image resolves: there the robot counts as exact.
  constexpr double kExactT = 2e-6, kExactR = 5e-6;
  Noise& noise = state->noise;
  noise.robot_t = updated(square_t, trace_t, noise.robot_t, kExactT);
  noise.robot_r = updated(square_r, trace_r, noise.robot_r, kExactR);
}

void estimateCovariance(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                        const AdjustOptions& options, Adjusted* state) {
  const auto normals = normalsOf(problem, views, options, *state);
  const auto covariance = normals ? invertInformation(normals->information, options) : std::nullopt;
  state->degenerate = !covariance;
  state->covariance = covariance ? *covariance : Eigen::MatrixXd::Zero(kColumns, kColumns);
  state->camera_model_error = 0.0;
  if (state->degenerate) return;
  widenByScoreScatter(*normals, options, state);
  if (options.fixed_camera && !options.free_scale) widenByGivenCamera(problem, *normals, state);
}

}  // namespace planar_bin_picking
