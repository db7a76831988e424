// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/noise_estimate.h"

#include "base/scatter.h"
#include "calibrate/hand_eye/model_error.h"
#include "calibrate/hand_eye/normal_equations.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <optional>

namespace planar_bin_picking {
namespace {

/// Beyond so many standard deviations a corner's influence no longer grows (Huber).
constexpr double kHuber = 2.5;

/// Errors of the board's corners in one view; of those that were not seen nothing.
using CornerErrors = std::vector<std::optional<Eigen::Vector2d>>;

CornerErrors errorsOnBoard(const Board& board, const Observation& view,
                           const std::vector<Eigen::Vector2d>& residuals) {
  CornerErrors errors(board.size());
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    errors[view.ids.empty() ? i : view.ids[i]] = residuals[i];
  }
  return errors;
}

/// Correlation of the errors of corners that are neighbours, over all views; that which independent
/// errors have by chance is taken off.
double neighbourCorrelation(const Board& board, const std::vector<CornerErrors>& views) {
  double products = 0.0, squares = 0.0, pairs = 0.0, corners = 0.0;
  const auto cols = static_cast<std::size_t>(board.cols);
  for (const CornerErrors& r : views) {
    const auto addPair = [&](std::size_t i, std::size_t k) {
      if (!r[k]) return;
      products += r[i]->dot(*r[k]);
      pairs += 1.0;
    };
    for (std::size_t i = 0; i < r.size(); ++i) {
      if (!r[i]) continue;
      squares += r[i]->squaredNorm();
      corners += 1.0;
      if (i % cols + 1 < cols) addPair(i, i + 1);
      if (i + cols < r.size()) addPair(i, i + cols);
    }
  }
  if (!(squares > 0.0) || !(pairs > 0.0)) return 0.0;
  const double by_chance = 2.0 / std::sqrt(2.0 * pairs);
  constexpr double kMost = 0.95;
  return std::clamp(products / pairs / (squares / corners) - by_chance, 0.0, kMost);
}

/// By what correlated corners move a board more than independent ones do: standard deviations, mean
/// over its shift, turn and size in the picture. The correlation falls with every square.
double wideningOf(const Board& board, double correlation) {
  if (!(correlation > 0.0)) return 1.0;
  const auto n = static_cast<Eigen::Index>(board.size());
  Eigen::MatrixXd R(n, n), basis(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d x = board.corner(static_cast<std::size_t>(i));
    basis.row(i) << 1.0, x.x(), x.y();
    for (Eigen::Index k = 0; k < n; ++k) {
      const double squares = (x - board.corner(static_cast<std::size_t>(k))).norm() / board.square;
      R(i, k) = std::pow(correlation, squares);
    }
  }
  const Eigen::MatrixXd Q =
      Eigen::HouseholderQR<Eigen::MatrixXd>(basis).householderQ() * Eigen::MatrixXd::Identity(n, 3);
  return std::sqrt(std::max(1.0, (Q.transpose() * R * Q).trace() / 3.0));
}

/// Degrees of freedom that the solution has taken from the corners. Of a view's correction those
/// that the corners determine: what an accurate robot holds follows no corner.
double takenFromCorners(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                        const AdjustOptions& options, const Adjusted& state) {
  const auto shared = static_cast<double>(estimatedColumns(options).size());
  double corrections = 6.0 * static_cast<double>(views.size());
  const auto normals = normalsOf(problem, views, options, state);
  if (!normals) return shared + corrections;
  const double square_t = std::pow(state.noise.robot_t, 2);
  const double square_r = std::pow(state.noise.robot_r, 2);
  for (const Normal& normal : normals->views) {
    const Matrix6d posterior = normal.correction.inverse();
    corrections -= posterior.topLeftCorner<3, 3>().trace() / square_t +
                   posterior.bottomRightCorner<3, 3>().trace() / square_r;
  }
  return shared + std::max(0.0, corrections);
}

/// Pixel noise from the median distance, each corner's weight, and how much correlation widens.
void weighCorners(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                  const AdjustOptions& options, Adjusted* state) {
  std::vector<std::vector<double>> distances;
  std::vector<double> all;
  std::vector<CornerErrors> errors;
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::vector<double>& of_view = distances.emplace_back();
    const auto of_corners =
        residuals(state->chain, problem.board, *views[i], state->corrections[i]);
    errors.push_back(errorsOnBoard(problem.board, *views[i], of_corners));
    for (const auto& r : of_corners) {
      of_view.push_back(r.norm());
      all.push_back(r.norm());
    }
  }
  const double count = 2.0 * static_cast<double>(all.size());
  const double taken = takenFromCorners(problem, views, options, *state);
  constexpr double kMedianOfRayleigh = 1.1774;
  // Drawn images have corners without any noise; the floor keeps the weights finite.
  const double sigma = std::max(
      1e-3, median(all) / kMedianOfRayleigh * std::sqrt(count / std::max(1.0, count - taken)));
  state->noise.pixel = sigma;
  state->noise.widening = wideningOf(problem.board, neighbourCorrelation(problem.board, errors));
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
  scaleByScoreScatter(*normals, options, state);
  if (options.fixed_camera && !options.free_scale) widenByGivenCamera(problem, *normals, state);
}

}  // namespace planar_bin_picking
