// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The normal equations of a solution, view by view, in standard deviations.

#include "calibrate/hand_eye/adjustment.h"

namespace planar_bin_picking {

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
