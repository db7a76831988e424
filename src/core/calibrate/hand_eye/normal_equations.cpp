// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/normal_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <cmath>

namespace planar_bin_picking {

namespace {

/// @param observation  without corners: they are as predicted
std::optional<Normal> normalOf(const Chain& chain, const Noise& noise,
                               const std::vector<Eigen::Vector3d>& points,
                               const Observation& observation, const Vector6d& correction,
                               const std::vector<double>& weights) {
  const std::vector<Eigen::Vector2d>& corners = observation.corners;
  // About the corrected pose, where the correction itself is zero.
  const auto prediction =
      predict(chain, observation.T_base_flange * exp(correction), Increment(), points, true);
  if (!prediction) return std::nullopt;
  Eigen::VectorXd w(prediction->pixels.size()), residual = Eigen::VectorXd::Zero(w.size());
  for (Eigen::Index i = 0; i < w.size(); ++i) {
    const auto corner = static_cast<std::size_t>(i / 2);
    w[i] = std::sqrt(weights[corner]) / noise.effectivePixel();
    if (!corners.empty()) residual[i] = corners[corner][i % 2] - prediction->pixels[i];
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
  // Schur's complement: what the correction itself would still follow is not left to the others.
  residual = w.cwiseProduct(residual);
  const Vector6d of_correction = c.transpose() * residual - prior.cwiseProduct(correction);
  normal.score =
      s.transpose() * residual - normal.mixed * normal.correction.llt().solve(of_correction);
  return normal;
}

}  // namespace

Eigen::MatrixXd Normal::marginal() const {
  return shared - mixed * correction.llt().solve(mixed.transpose());
}

Eigen::Matrix<double, 1, 6> KnownHeight::jacobian(const Eigen::Isometry3d& T_other_board) const {
  Eigen::Matrix<double, 3, 6> by_increment;
  by_increment << Eigen::Matrix3d::Identity(), -skew<double>(p_board);
  return (T_other_board.linear() * by_increment).row(2) / sigma;
}

std::vector<Eigen::Index> estimatedColumns(const AdjustOptions& options) {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index i = 0; i < kColumns; ++i) {
    if (i < kHandEye && options.fixed_camera) continue;
    const bool is_denominator = i >= static_cast<Eigen::Index>(kDenominator) && i < kHandEye;
    if (is_denominator && options.lens != LensFreedom::kRational) continue;
    if (i == kScale && !options.free_scale) continue;
    columns.push_back(i);
  }
  return columns;
}

std::optional<Normals> normalsOf(const HandEyeProblem& problem,
                                 const std::vector<const Observation*>& views,
                                 const AdjustOptions& options, const Adjusted& state) {
  Normals out;
  out.information = Eigen::MatrixXd::Zero(kColumns, kColumns);
  for (std::size_t i = 0; i < views.size(); ++i) {
    auto normal = normalOf(state.chain, state.noise, views[i]->points(problem.board), *views[i],
                           state.corrections[i], state.weights[i]);
    if (!normal) return std::nullopt;
    out.information += normal->marginal();
    out.views.push_back(std::move(*normal));
  }
  const auto lens = lensPrior(state.chain.intrinsics, problem.width, problem.height, options.lens);
  for (std::size_t i = 0; i < lens.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (lens[i] > 0.0) out.information(k, k) += 1.0 / (lens[i] * lens[i]);
  }
  if (options.height) {
    const auto J = options.height->jacobian(state.chain.T_other_board);
    out.information.block<6, 6>(kBoard, kBoard) += J.transpose() * J;
  }
  return out;
}

Eigen::MatrixXd viewInformation(const Chain& chain, const Noise& noise,
                                const std::vector<Eigen::Vector3d>& points,
                                const Eigen::Isometry3d& T_base_flange) {
  const std::vector<double> weights(points.size(), 1.0);
  const auto normal =
      normalOf(chain, noise, points, {"", T_base_flange, {}}, Vector6d::Zero(), weights);
  if (!normal) return Eigen::MatrixXd::Zero(kColumns, kColumns);
  return normal->marginal();
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

}  // namespace planar_bin_picking
