// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Chooses where the robot goes next so that a calibration gets good with few views: small turns
/// about the start first, since nothing is known of the camera's place and a large move could lose
/// the board; then, from a provisional solution, whichever view is expected to lower the error
/// most, among those in which the board is surely seen, however uncertain the solution still is.
///
/// Knows no robot and no camera: the caller moves, looks and tells what came of it.

#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

namespace planar_bin_picking {

struct RunParams {
  double workspace_min_x = -2.0, workspace_min_y = -2.0,
         workspace_min_z = -2.0;  ///< of the flange, metres,
  double workspace_max_x = 2.0, workspace_max_y = 2.0,
         workspace_max_z = 2.0;  ///< in the base frame
  double cone_deg = 45.0;  ///< the flange's z axis stays within this of where it was at the start
  double first_turn_deg = 8.0;  ///< of the first, small moves
  double tilt_max_deg = 40.0;   ///< of the board against the image plane
  double margin_px = 20.0;      ///< that the board keeps from the image's border
  int views_max = 15;           ///< pictures of the board
  int attempts_max = 60;        ///< poses asked for, refused ones included
  int candidates = 150;         ///< looked at for each view
  int seed = 1;

  /// Calls visit(key, member, min, max) for every parameter.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("workspace_min_x", self.workspace_min_x, -100.0, 100.0);
    visit("workspace_min_y", self.workspace_min_y, -100.0, 100.0);
    visit("workspace_min_z", self.workspace_min_z, -100.0, 100.0);
    visit("workspace_max_x", self.workspace_max_x, -100.0, 100.0);
    visit("workspace_max_y", self.workspace_max_y, -100.0, 100.0);
    visit("workspace_max_z", self.workspace_max_z, -100.0, 100.0);
    visit("cone_deg", self.cone_deg, 5.0, 180.0);
    visit("first_turn_deg", self.first_turn_deg, 1.0, 30.0);
    visit("tilt_max_deg", self.tilt_max_deg, 10.0, 70.0);
    visit("margin_px", self.margin_px, 0.0, 1000.0);
    visit("views_max", self.views_max, 5, 1000);
    visit("attempts_max", self.attempts_max, 5, 10000);
    visit("candidates", self.candidates, 10, 10000);
    visit("seed", self.seed, 0, 1000000);
  }
};

/// @throws std::invalid_argument  a field out of its range or an empty workspace: key, value,
/// remedy
void validate(const RunParams& params);

/// A pose that was asked for, for people to look at.
struct PlannedPose {
  enum class State { kPlanned, kSeen, kRefused, kLost };
  Eigen::Isometry3d T_base_flange = Eigen::Isometry3d::Identity();
  State state = State::kPlanned;
};

class CalibrationRun {
 public:
  /// @param empty  the problem without observations
  /// @param start  flange pose from which the board is seen
  /// @throws std::invalid_argument  bad params or problem; the start lies outside the workspace
  CalibrationRun(const HandEyeProblem& empty, const HandEyeParams& solver, const RunParams& params,
                 const Eigen::Isometry3d& T_base_start);

  /// Where to go for the next picture; the first one is the start itself. Nothing once the error is
  /// small enough, or views or attempts are used up, or no pose is left.
  std::optional<Eigen::Isometry3d> next();

  // What came of the pose that next() gave.
  void refused();  ///< the robot did not go there
  void lost();     ///< it went, and the board was not seen
  void seen(const Observation& observation);

  /// The verdict over all that was seen.
  HandEyeResult result() const { return solveHandEye(problem_, solver_); }

  const HandEyeProblem& problem() const { return problem_; }
  /// Provisional; nothing before the first small moves are done.
  const std::optional<HandEyeResult>& solution() const { return solution_; }
  int attempts() const { return attempts_; }
  const std::vector<PlannedPose>& poses() const { return poses_; }  ///< all asked for, in order
  /// In the workspace and in the cone.
  bool allowed(const Eigen::Isometry3d& T_base_flange) const;

 private:
  std::optional<Eigen::Isometry3d> firstMove();
  std::optional<Eigen::Isometry3d> bestMove();
  void update();
  bool isNearRefused(const Eigen::Isometry3d& T_base_flange) const;

  HandEyeProblem problem_;
  const HandEyeParams solver_;
  const RunParams params_;
  const Eigen::Isometry3d T_base_start_;
  std::mt19937 random_;
  int attempts_ = 0, first_moves_ = 0;
  double turn_;           // of the first moves, radians; smaller once the board was lost
  double caution_ = 1.0;  // factor on the uncertainty; larger once the board was lost
  std::vector<PlannedPose> poses_;
  std::vector<Eigen::Isometry3d> refused_;
  std::optional<HandEyeResult> solution_;  // provisional
};

}  // namespace planar_bin_picking
