// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The chain of hand_eye.h, from one robot pose to the board's corners, and its derivatives.

#include "calibrate/board/board_views.h"
#include "planar_bin_picking/calibrate/hand_eye/hand_eye_problem.h"

#include <array>

namespace planar_bin_picking {

/// Columns of a view's Jacobian: the shared parameters, then the logarithm of the board's scale.
constexpr int kScale = kSharedSize, kColumns = kSharedSize + 1;

/// fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6; the last three, of rational_polynomial alone, follow the
/// others.
using Intrinsics = std::array<double, kHandEye>;
constexpr std::size_t kDenominator = 9;  ///< k4

/// A point in the space of all shared parameters.
struct Chain {
  Mounting mounting = Mounting::kEyeInHand;
  Intrinsics intrinsics{};
  Eigen::Isometry3d T_mount_camera = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_other_board = Eigen::Isometry3d::Identity();
  double scale = 1.0;  ///< of the board

  Eigen::Isometry3d cameraBoard(const Eigen::Isometry3d& T_base_flange) const;
};

/// Increments about a chain and about one robot pose.
struct Increment {
  Vector6d mount_camera = Vector6d::Zero(), other_board = Vector6d::Zero();
  Vector6d correction = Vector6d::Zero();
  double log_scale = 0.0;
};

/// Predictions of corners of a view, one row per coordinate (u0 v0 u1 v1 ...).
struct Prediction {
  Eigen::VectorXd pixels;
  Eigen::MatrixXd shared;      ///< by the shared parameters and the scale, kColumns columns
  Eigen::MatrixXd correction;  ///< by the correction, 6 columns
};

/// @param points     corners of the board, in its frame
/// @param jacobians  whether to fill the matrices
/// @return  nothing where a corner is not in front of the camera
std::optional<Prediction> predict(const Chain& chain, const Eigen::Isometry3d& T_base_flange,
                                  const Increment& increment,
                                  const std::vector<Eigen::Vector3d>& points, bool jacobians);

SeenPoints seenPoints(const Board& board, const Observation& observation);

/// Residuals of a view: seen minus predicted. Empty where the prediction fails.
std::vector<Eigen::Vector2d> residuals(const Chain& chain, const Board& board,
                                       const Observation& observation, const Vector6d& correction);

/// The intrinsics as Camera has them, and back; plumb_bob where k4 k5 k6 are zero.
Camera::Model toModel(const Intrinsics& intrinsics, int width, int height);
Intrinsics fromModel(const Camera::Model& model);

/// The chain of a solution.
Chain chainOf(const HandEyeProblem& problem, const HandEyeResult& solution);

/// Root mean square over the corners of the distance; both of one size, not empty.
double rms(const std::vector<Eigen::Vector2d>& residuals);

/// The increment applied, and the place of a corrected robot pose.
Chain moved(const Chain& chain, const Increment& increment);

/// How freely the lens is estimated. Where one folds the image over, a plainer one is tried.
enum class LensFreedom {
  kRational,     ///< eight coefficients: rational_polynomial
  kFull,         ///< five coefficients, within what a strong lens has: plumb_bob
  kStiff,        ///< likewise, within a tenth of that
  kFirstRadial,  ///< k1 alone
  kNone,         ///< a pinhole
};

/// Standard deviations that keep lens coefficients sane while views are few: each term may move the
/// image's corner by a large share of its distance from the centre; see chain.cpp. Order
/// as intrinsics. Zero: no such limit.
Intrinsics lensPrior(const Intrinsics& intrinsics, int width, int height,
                     LensFreedom freedom = LensFreedom::kFull);

}  // namespace planar_bin_picking
