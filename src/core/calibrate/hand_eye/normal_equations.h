// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The state of the bundle adjustment, which its units pass on (solution, noise, weights,
/// covariance), and its normal equations, view by view, in standard deviations.

#include "calibrate/hand_eye/chain.h"

#include <optional>
#include <vector>

namespace planar_bin_picking {

/// Noise that weighs the errors against each other; standard deviations per coordinate.
struct Noise {
  double pixel = 0.2;     ///< pixels
  double robot_t = 1e-3;  ///< metres
  double robot_r = 2e-3;  ///< radians
  /// By which correlated corners of a view weigh less than independent ones, a factor on `pixel`.
  double widening = 1.0;

  double effectivePixel() const { return pixel * widening; }
};

/// Height of a board that a robot touched, which turns about the vertical axis alone.
struct KnownHeight {
  Eigen::Vector3d p_board = Eigen::Vector3d::Zero();  ///< the point that was touched
  double z = 0.0, sigma = 1e-3;                       ///< of it, in the board's other frame; metres

  /// How much too high the board is, in standard deviations, and how that follows its increment.
  double error(const Eigen::Isometry3d& T_other_board) const {
    return ((T_other_board * p_board).z() - z) / sigma;
  }
  Eigen::Matrix<double, 1, 6> jacobian(const Eigen::Isometry3d& T_other_board) const;
};

struct AdjustOptions {
  bool fixed_camera = false;
  bool free_scale = false;
  LensFreedom lens = LensFreedom::kFull;
  std::optional<KnownHeight> height;
  bool fixed_robot_noise = false;  ///< given by the user; otherwise estimated
  int rounds = 12;  ///< of re-estimating the noise; 0 = one solve with the noise as it is
};

/// State of the solution over some of the observations.
struct Adjusted {
  Chain chain;
  Noise noise;
  std::vector<Vector6d> corrections;         ///< one per view
  std::vector<std::vector<double>> weights;  ///< of each corner, 0..1
  Eigen::MatrixXd covariance;                ///< kColumns square; zero where not estimated
  bool converged = false;
  bool degenerate = false;  ///< the covariance does not exist
  /// Squared residuals, in variances, that another camera than the given one would take away; 0
  /// where that many could do so by chance.
  double camera_model_error = 0.0;
};

/// Of one view: shared parameters, correction, and both.
struct Normal {
  Eigen::MatrixXd shared;  // kColumns square
  Eigen::MatrixXd mixed;   // kColumns x 6
  Matrix6d correction;     // with the prior
  Eigen::VectorXd score;  // gradient of its log-likelihood by the shared parameters; over all views
                          // it sums to 0

  /// What the view tells about the shared parameters while its correction is open.
  Eigen::MatrixXd marginal() const;
};

struct Normals {
  std::vector<Normal> views;
  Eigen::MatrixXd information;  // their sum and the lens prior
};

/// @return  nothing where a board is not in front of the camera
std::optional<Normals> normalsOf(const HandEyeProblem& problem,
                                 const std::vector<const Observation*>& views,
                                 const AdjustOptions& options, const Adjusted& state);

/// What one view tells about the shared parameters (kColumns square), its robot correction
/// marginalised.
/// @param points  the corners that are seen, in the board's frame
/// @return  zero where the board is not in front of the camera
Eigen::MatrixXd viewInformation(const Chain& chain, const Noise& noise,
                                const std::vector<Eigen::Vector3d>& points,
                                const Eigen::Isometry3d& T_base_flange);

/// The inverse of the information over the estimated columns; the others stay zero.
/// @return  nothing where it is singular
std::optional<Eigen::MatrixXd> invertInformation(const Eigen::MatrixXd& information,
                                                 const AdjustOptions& options);

std::vector<Eigen::Index> estimatedColumns(const AdjustOptions& options);

}  // namespace planar_bin_picking
