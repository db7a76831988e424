// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The state of the bundle adjustment, which its units pass on: solution, noise, weights,
/// covariance.

#include "calibrate/hand_eye/chain.h"

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

struct AdjustOptions {
  bool fixed_camera = false;
  bool free_scale = false;
  LensFreedom lens = LensFreedom::kFull;
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

}  // namespace planar_bin_picking
