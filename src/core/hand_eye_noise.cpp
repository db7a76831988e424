// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hand_eye_noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Beyond so many standard deviations a corner's pull no longer grows (Huber).
constexpr double kHuber = 2.5;

/// The normal equations of one view in standard deviations: shared parameters, correction, and
/// both.
struct Normal {
  Eigen::MatrixXd shared;  // kColumns square
  Eigen::MatrixXd mixed;   // kColumns x 6
  Matrix6d correction;     // with the prior
};

std::optional<Normal> normalOf(const Chain& chain, const Noise& noise, const Board& board,
                               const Eigen::Isometry3d& T_base_flange, const Vector6d& correction,
                               const std::vector<double>& weights) {
  // About the corrected pose, where the correction itself is zero.
  const auto prediction = predict(chain, T_base_flange * exp(correction), Increment(), board, true);
  if (!prediction) return std::nullopt;
  Eigen::VectorXd w(prediction->pixels.size());
  for (Eigen::Index i = 0; i < w.size(); ++i) {
    w[i] = std::sqrt(weights[static_cast<std::size_t>(i / 2)]) / noise.pixel;
  }
  const Eigen::MatrixXd s = w.asDiagonal() * prediction->shared;
  const Eigen::MatrixXd c = w.asDiagonal() * prediction->correction;
  Vector6d prior;
  prior << Eigen::Vector3d::Constant(1.0 / (noise.robot_t * noise.robot_t)),
      Eigen::Vector3d::Constant(1.0 / (noise.robot_r * noise.robot_r));
  Normal normal;
  normal.shared = s.transpose() * s;
  normal.mixed = s.transpose() * c;
  normal.correction = c.transpose() * c;
  normal.correction.diagonal() += prior;
  return normal;
}

Eigen::MatrixXd marginal(const Normal& normal) {
  return normal.shared - normal.mixed * normal.correction.llt().solve(normal.mixed.transpose());
}

std::vector<Eigen::Index> estimatedColumns(const AdjustOptions& options) {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index i = 0; i < kColumns; ++i) {
    if (i < kHandEye && options.fixed_camera) continue;
    if (i == kScale && !options.free_scale) continue;
    columns.push_back(i);
  }
  return columns;
}

struct Normals {
  std::vector<Normal> views;
  Eigen::MatrixXd information;
};

std::optional<Normals> normalsOf(const HandEyeProblem& problem,
                                 const std::vector<const Sighting*>& views,
                                 const AdjustOptions& options, const Adjusted& state) {
  Normals out;
  out.information = Eigen::MatrixXd::Zero(kColumns, kColumns);
  for (std::size_t i = 0; i < views.size(); ++i) {
    auto normal = normalOf(state.chain, state.noise, problem.board, views[i]->T_base_flange,
                           state.corrections[i], state.weights[i]);
    if (!normal) return std::nullopt;
    out.information += marginal(*normal);
    out.views.push_back(std::move(*normal));
  }
  const auto lens = lensPrior(state.chain.intrinsics, problem.width, problem.height);
  for (std::size_t i = 0; i < lens.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double sigma = options.lens_share * lens[i];
    if (sigma > 0.0) out.information(k, k) += 1.0 / (sigma * sigma);
  }
  return out;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Pixel noise from the median distance, and each corner's weight.
void weighCorners(const HandEyeProblem& problem, const std::vector<const Sighting*>& views,
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

Eigen::MatrixXd viewInformation(const Chain& chain, const Noise& noise, const Board& board,
                                const Eigen::Isometry3d& T_base_flange,
                                const std::vector<double>& weights) {
  const auto normal = normalOf(chain, noise, board, T_base_flange, Vector6d::Zero(), weights);
  if (!normal) return Eigen::MatrixXd::Zero(kColumns, kColumns);
  return marginal(*normal);
}

std::optional<Eigen::MatrixXd> invertInformation(const Eigen::MatrixXd& information,
                                                 const AdjustOptions& options) {
  const std::vector<Eigen::Index> columns = estimatedColumns(options);
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd part(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      part(i, k) =
          information(columns[static_cast<std::size_t>(i)], columns[static_cast<std::size_t>(k)]);
    }
  }
  // Pixels, metres and lens coefficients: scaled to a unit diagonal before anything is compared.
  if (!(part.diagonal().minCoeff() > 0.0)) return std::nullopt;
  const Eigen::VectorXd scale = part.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * part *
                                                             scale.asDiagonal());
  if (eigen.info() != Eigen::Success || !(eigen.eigenvalues()[0] > 1e-13)) return std::nullopt;
  const Eigen::MatrixXd V = scale.asDiagonal() * eigen.eigenvectors();
  const Eigen::MatrixXd inverse =
      V * eigen.eigenvalues().cwiseInverse().asDiagonal() * V.transpose();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kColumns, kColumns);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      covariance(columns[static_cast<std::size_t>(i)], columns[static_cast<std::size_t>(k)]) =
          inverse(i, k);
    }
  }
  return covariance;
}

void estimateNoise(const HandEyeProblem& problem, const std::vector<const Sighting*>& views,
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

void estimateCovariance(const HandEyeProblem& problem, const std::vector<const Sighting*>& views,
                        const AdjustOptions& options, Adjusted* state) {
  const auto normals = normalsOf(problem, views, options, *state);
  const auto covariance = normals ? invertInformation(normals->information, options) : std::nullopt;
  state->degenerate = !covariance;
  state->covariance = covariance ? *covariance : Eigen::MatrixXd::Zero(kColumns, kColumns);
}

std::vector<Eigen::Vector2d> residuals(const Chain& chain, const Board& board,
                                       const Sighting& sighting, const Vector6d& correction) {
  Increment increment;
  increment.correction = correction;
  const auto prediction = predict(chain, sighting.T_base_flange, increment, board, false);
  std::vector<Eigen::Vector2d> out;
  if (!prediction) return out;
  for (std::size_t i = 0; i < sighting.corners.size(); ++i) {
    out.push_back(sighting.corners[i] -
                  prediction->pixels.segment<2>(2 * static_cast<Eigen::Index>(i)));
  }
  return out;
}

}  // namespace planar_bin_picking
