// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a solution is worth.

#include "calibrate/hand_eye/chain.h"

namespace planar_bin_picking {

struct ExpectedError {
  double metres = 0.0, radians = 0.0;
};

/// RMS error of the pose, in the mount's frame, of a small part that faces the camera at
/// `distance`, over five places in the image: the error of T_mount_camera and, through the part's
/// measured pose, that of the intrinsics, with all their correlations. Set up once per chain.
class ErrorModel {
 public:
  ErrorModel(const Chain& chain, int width, int height, double distance);
  /// @param places  others, in shares of the image's width and height
  ErrorModel(const Chain& chain, int width, int height, double distance,
             const std::vector<Eigen::Vector2d>& places);
  ExpectedError of(const Eigen::MatrixXd& covariance) const;

 private:
  std::vector<Eigen::Matrix<double, 6, kBoard>> by_calibration_;  // of each place's pose
};

/// What the checks before the solution found.
struct Findings {
  std::vector<std::string> stale;   ///< observations whose robot pose is older than their image
  bool late_by_one = false;         ///< all poses fit the image before their own
  std::vector<std::string> frozen;  ///< pictures that are the same though the robot went elsewhere
  std::size_t repeated = 0;         ///< observations that are a view once more
  std::string turns;    ///< why the robot's turns do not determine the camera; "" where they do
  std::string mistake;  ///< of the input, which explains why nothing fits; "" where there is none
  std::string camera_error;  ///< why the estimated lens cannot be used; "" where it can
};

/// By how much one view alone may move the camera, mm.
struct LeaveOneOutLimits {
  double sigma = 0.0;  ///< as stated of the camera's place; by chance a view moves it by about that
  double poor = 0.0;   ///< more gives POOR
  double refused = 0.0;  ///< and more than this REFUSED
};
LeaveOneOutLimits leaveOneOutLimits(const HandEyeParams& params, const HandEyeResult& result);

/// Sets verdict and reasons from all other fields. A named mistake comes first.
void judge(const HandEyeProblem& problem, const HandEyeParams& params, const Findings& findings,
           HandEyeResult* result);

}  // namespace planar_bin_picking
