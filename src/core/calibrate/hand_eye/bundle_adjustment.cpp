// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/bundle_adjustment.h"

#include "calibrate/hand_eye/noise_estimate.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// All corners of one view against their predictions, in standard deviations.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const HandEyeProblem& problem, const Observation& observation, const Adjusted& state,
           const std::vector<double>& weights, bool is_rational)
      : points_(observation.points(problem.board)),
        observation_(observation),
        chain_(state.chain),
        is_rational_(is_rational) {
    set_num_residuals(2 * static_cast<int>(points_.size()));
    *mutable_parameter_block_sizes() = {kHandEye, 6, 6, 1, 6};
    for (const double weight : weights)
      roots_.push_back(std::sqrt(weight) / state.noise.effectivePixel());
  }

  bool Evaluate(double const* const* parameters, double* out, double** jacobians) const override {
    using Xi = Eigen::Map<const Vector6d>;
    Chain chain = chain_;
    std::copy(parameters[0], parameters[0] + kHandEye, chain.intrinsics.begin());
    const Increment increment{Xi(parameters[1]), Xi(parameters[2]), Xi(parameters[4]),
                              parameters[3][0]};
    const auto prediction =
        predict(chain, observation_.T_base_flange, increment, points_, jacobians != nullptr);
    if (!prediction) return false;
    for (Eigen::Index i = 0; i < prediction->pixels.size(); ++i) {
      const auto corner = static_cast<std::size_t>(i / 2);
      out[i] = roots_[corner] * (prediction->pixels[i] - observation_.corners[corner][i % 2]);
    }
    if (jacobians == nullptr) return true;
    const Eigen::MatrixXd& shared = prediction->shared;
    fill(shared.middleCols(kIntrinsics, kHandEye), jacobians[0]);
    if (!is_rational_) holdDenominator(jacobians[0]);
    fill(shared.middleCols(kHandEye, 6), jacobians[1]);
    fill(shared.middleCols(kBoard, 6), jacobians[2]);
    fill(shared.middleCols(kScale, 1), jacobians[3]);
    fill(prediction->correction, jacobians[4]);
    return true;
  }

 private:
  /// Nothing moves k4 k5 k6 then.
  void holdDenominator(double* jacobian) const {
    if (jacobian == nullptr) return;
    for (int row = 0; row < num_residuals(); ++row) {
      std::fill(jacobian + row * kHandEye + kDenominator, jacobian + (row + 1) * kHandEye, 0.0);
    }
  }

  template <class Block>
  void fill(const Block& block, double* jacobian) const {
    if (jacobian == nullptr) return;
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
      for (Eigen::Index k = 0; k < block.cols(); ++k) {
        *jacobian++ = roots_[static_cast<std::size_t>(i / 2)] * block(i, k);
      }
    }
  }

  const std::vector<Eigen::Vector3d> points_;
  const Observation& observation_;
  const Chain& chain_;
  const bool is_rational_;
  std::vector<double> roots_;
};

/// value / sigma of each element; no residual where sigma is 0.
class PriorCost : public ceres::CostFunction {
 public:
  explicit PriorCost(std::vector<double> sigmas) : sigmas_(std::move(sigmas)) {
    set_num_residuals(static_cast<int>(sigmas_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(sigmas_.size()));
  }
  bool Evaluate(double const* const* parameters, double* out, double** jacobians) const override {
    const std::size_t n = sigmas_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const double w = sigmas_[i] > 0.0 ? 1.0 / sigmas_[i] : 0.0;
      out[i] = w * parameters[0][i];
      if (jacobians == nullptr || jacobians[0] == nullptr) continue;
      for (std::size_t k = 0; k < n; ++k) jacobians[0][i * n + k] = i == k ? w : 0.0;
    }
    return true;
  }

 private:
  std::vector<double> sigmas_;
};

/// A board of known height.
class HeightCost : public ceres::SizedCostFunction<1, 6> {
 public:
  HeightCost(const KnownHeight& height, const Eigen::Isometry3d& T_other_board)
      : height_(height), T_other_board_(T_other_board) {}
  bool Evaluate(double const* const* parameters, double* out, double** jacobians) const override {
    const Eigen::Map<const Vector6d> xi(parameters[0]);
    const Eigen::Isometry3d T = T_other_board_ * exp(xi);
    out[0] = height_.error(T);
    // Steps are small: the increment's own derivative is taken for one.
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 1, 6>> J(jacobians[0]);
      J = height_.jacobian(T);
    }
    return true;
  }

 private:
  const KnownHeight height_;
  const Eigen::Isometry3d T_other_board_;
};

/// Ceres tells its log, and so stderr, of each step that it could not take; what comes of a solve
/// is told by its summary.
class QuietCeres {
 public:
  QuietCeres() { FLAGS_minloglevel = google::GLOG_FATAL; }
  ~QuietCeres() { FLAGS_minloglevel = before_; }
  QuietCeres(const QuietCeres&) = delete;
  QuietCeres& operator=(const QuietCeres&) = delete;

 private:
  const int before_ = FLAGS_minloglevel;
};

ceres::Solver::Options solverOptions() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 60;
  options.function_tolerance = 1e-10;
  options.parameter_tolerance = 1e-10;
  options.num_threads = 1;  // the same bytes every time
  options.logging_type = ceres::SILENT;
  return options;
}

/// One solve with noise and weights as they are in `state`.
void solveOnce(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
               const AdjustOptions& options, Adjusted* state) {
  Intrinsics intrinsics = state->chain.intrinsics;
  Increment shared;
  std::vector<Vector6d> corrections = state->corrections;
  ceres::Problem problem_ceres;
  const auto ordering = new ceres::ParameterBlockOrdering;
  const Noise& noise = state->noise;
  std::vector<double> prior(3, noise.robot_t);
  prior.insert(prior.end(), 3, noise.robot_r);
  double *const x = shared.mount_camera.data(), *const z = shared.other_board.data();
  for (std::size_t i = 0; i < views.size(); ++i) {
    double* const c = corrections[i].data();
    problem_ceres.AddResidualBlock(new ViewCost(problem, *views[i], *state, state->weights[i],
                                                options.lens == LensFreedom::kRational),
                                   nullptr, intrinsics.data(), x, z, &shared.log_scale, c);
    problem_ceres.AddResidualBlock(new PriorCost(prior), nullptr, c);
    ordering->AddElementToGroup(c, 0);
  }
  for (double* block : {intrinsics.data(), x, z, &shared.log_scale}) {
    ordering->AddElementToGroup(block, 1);
  }
  if (options.fixed_camera) {
    problem_ceres.SetParameterBlockConstant(intrinsics.data());
  } else {
    const auto lens = lensPrior(intrinsics, problem.width, problem.height, options.lens);
    problem_ceres.AddResidualBlock(new PriorCost({lens.begin(), lens.end()}), nullptr,
                                   intrinsics.data());
  }
  if (!options.free_scale) problem_ceres.SetParameterBlockConstant(&shared.log_scale);
  if (options.height) {
    problem_ceres.AddResidualBlock(new HeightCost(*options.height, state->chain.T_other_board),
                                   nullptr, z);
  }
  ceres::Solver::Options solver = solverOptions();
  solver.linear_solver_ordering.reset(ordering);
  ceres::Solver::Summary summary;
  const QuietCeres quiet;
  ceres::Solve(solver, &problem_ceres, &summary);
  state->converged = summary.IsSolutionUsable();
  if (!state->converged) return;
  state->chain = moved(state->chain, shared);
  state->chain.intrinsics = intrinsics;
  state->corrections = corrections;
}

}  // namespace

Adjusted startAt(const Chain& chain, const Noise& noise,
                 const std::vector<const Observation*>& views) {
  Adjusted state;
  state.chain = chain;
  state.noise = noise;
  for (const Observation* const view : views) {
    state.corrections.emplace_back(Vector6d::Zero());
    state.weights.emplace_back(view->corners.size(), 1.0);
  }
  return state;
}

Adjusted adjust(const HandEyeProblem& problem, const std::vector<const Observation*>& views,
                const Adjusted& start, const AdjustOptions& options) {
  Adjusted state = start;
  for (int round = 0;; ++round) {
    solveOnce(problem, views, options, &state);
    if (!state.converged) return state;
    if (round >= options.rounds) break;
    const Noise before = state.noise;
    estimateNoise(problem, views, options, &state);
    if (state.degenerate) return state;
    const auto same = [](double a, double b) { return std::abs(a - b) < 0.02 * b; };
    if (same(state.noise.pixel, before.pixel) && same(state.noise.robot_t, before.robot_t) &&
        same(state.noise.robot_r, before.robot_r)) {
      break;
    }
  }
  estimateCovariance(problem, views, options, &state);
  return state;
}

}  // namespace planar_bin_picking
