// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibration_verifier.h"

#include "calibrator/sample_store.h"
#include "planar_bin_picking/calibrate/calibration_file.h"

#include <algorithm>
#include <stdexcept>

namespace planar_bin_picking_ros {

using planar_bin_picking::CalibrationCheck;
using planar_bin_picking::HandEyeProblem;
using planar_bin_picking::Observation;
using planar_bin_picking::SampleFolder;

namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
/// Within this time a robot program takes its views; whoever comes later begins anew.
constexpr std::chrono::minutes kOld(10);
constexpr std::size_t kViewsMost = 3;
/// Two views from poses that differ by less are one.
constexpr double kSameMetres = 1e-3, kSameRadians = 0.1 * kRadians;
/// What hand_eye.yaml may differ by from what its pictures give: rounding, and a solver that became
/// a little better.
constexpr double kFileMetres = 2e-4, kFileRadians = 0.02 * kRadians;

bool isNear(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double metres, double radians) {
  const Eigen::Isometry3d between = a.inverse() * b;
  return between.translation().norm() < metres &&
         planar_bin_picking::rotationAngle(between.linear()) < radians;
}

}  // namespace

void CalibrationVerifier::remember(const Look& look) {
  const auto now = Clock::now();
  const auto is_gone = [&](const View& view) {
    return now - view.taken > kOld ||
           isNear(view.observation.T_base_flange, look.T_base_flange, kSameMetres, kSameRadians);
  };
  views_.erase(std::remove_if(views_.begin(), views_.end(), is_gone), views_.end());
  if (views_.size() == kViewsMost) views_.erase(views_.begin());
  views_.push_back({{"this view", look.T_base_flange, look.board.corners, look.board.ids}, now});
}

CalibrationVerifier::Calibration CalibrationVerifier::calibration(
    const HandEyeProblem& empty) const {
  const std::string& folder = params_.output_folder;
  const auto file = planar_bin_picking::loadHandEye(folder + "/hand_eye.yaml");
  // A run that came to no calibration has set aside the pictures of the one that holds.
  std::string reasons;
  for (const std::string& at : {folder, folder + "/earlier_samples"}) {
    try {
      Calibration found{SampleFolder(at).load(), {}};
      found.set.problem.camera = empty.camera;
      found.result = solveHandEye(found.set.problem, params_.solver);
      if (found.result.solved &&
          isNear(found.result.T_mount_camera, file.T_parent_child, kFileMetres, kFileRadians)) {
        return found;
      }
      reasons += at + ": hand_eye.yaml is not what these pictures give; ";
    } catch (const std::exception& error) {
      reasons += std::string(error.what()) + "; ";
    }
  }
  throw std::runtime_error(folder +
                           "/hand_eye.yaml cannot be verified without the pictures it was "
                           "made of: " +
                           reasons + "calibrate anew");
}

CalibrationCheck CalibrationVerifier::verify(const Look& look, const HandEyeProblem& empty) {
  const Calibration known = calibration(empty);
  checkCamera(known.set, look);
  remember(look);
  std::vector<Observation> views;
  for (const View& view : views_) views.push_back(view.observation);
  return checkCalibration(known.set.problem, known.result, views);
}

}  // namespace planar_bin_picking_ros
