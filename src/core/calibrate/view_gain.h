// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a further view would be worth, and whether the board would surely be in it.

#include "calibrate/hand_eye/normal_equations.h"
#include "calibrate/hand_eye/verdict.h"

#include <array>
#include <random>

namespace planar_bin_picking {

class ViewGain {
 public:
  /// @param solution   solved
  /// @param margin_px  the board keeps this from the image's border, and three standard deviations
  /// of
  ///                   where it is expected, times
  /// @param caution    this
  ViewGain(const HandEyeProblem& problem, const HandEyeResult& solution, double margin_px,
           double caution);

  /// A flange pose from which the solution expects the board somewhere in the image: tilted,
  /// turned, near. Half of them turn little against the start.
  Eigen::Isometry3d draw(double tilt_max, const Eigen::Isometry3d& T_base_start,
                         std::mt19937* random) const;

  /// Expected error once this view is there: position and rotation of a part and of the camera
  /// itself, each against its present size, summed. The camera's own place counts since a part's
  /// errors cancel at one distance alone.
  /// @return  nothing where the board might leave the image, or be too slanted or small for the
  /// detector
  std::optional<double> errorAfter(const Eigen::Isometry3d& T_base_flange) const;

  /// Likewise, with the flange turned about the base's z axis alone.
  Eigen::Isometry3d drawUpright(const Eigen::Isometry3d& T_base_start, std::mt19937* random) const;

 private:
  /// Where the board's centre is to be seen from the camera.
  Eigen::Vector3d drawCentre(std::mt19937* random) const;
  bool surelySeen(const Eigen::Isometry3d& T_base_flange) const;

  const HandEyeProblem& problem_;
  Chain chain_;
  Noise noise_;
  Eigen::MatrixXd information_, covariance_;
  AdjustOptions options_;
  ErrorModel model_;
  double margin_px_, caution_;
  std::array<double, 4> errors_{};       // at present, see errorsOf
  std::vector<Eigen::Vector3d> points_;  // all corners of the board
};

}  // namespace planar_bin_picking
