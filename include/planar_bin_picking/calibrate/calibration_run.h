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
#include "planar_bin_picking/calibrate/motion_limits.h"

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

namespace planar_bin_picking {

struct RunParams {
  MotionParams motion;          ///< its keys stand beside those below
  double first_turn_deg = 8.0;  ///< of the first, small moves
  double tilt_max_deg = 40.0;   ///< of the board against the image plane
  double margin_px = 20.0;      ///< that the board keeps from the image's border
  int views_max = 15;           ///< pictures of the board
  int attempts_max = 60;        ///< poses asked for, refused ones included
  int refusals_max = 8;         ///< poses that the robot refuses without moving in between
  int candidates = 150;         ///< looked at for each view
  int seed = 1;

  /// Calls visit(key, member, min, max) for every parameter but the planes.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    MotionParams::fields(self.motion, visit);
    visit("first_turn_deg", self.first_turn_deg, 1.0, 30.0);
    visit("tilt_max_deg", self.tilt_max_deg, 10.0, 70.0);
    visit("margin_px", self.margin_px, 0.0, 1000.0);
    visit("views_max", self.views_max, 5, 1000);
    visit("attempts_max", self.attempts_max, 5, 10000);
    visit("refusals_max", self.refusals_max, 1, 10000);
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
  /// Why next() gave no further pose.
  enum class End {
    kNone,      ///< it did, or was not asked
    kGood,      ///< the expected error is small enough
    kViews,     ///< views_max
    kAttempts,  ///< attempts_max
    kRefusals,  ///< refusals_max
    kNoPose,    ///< no pose is left that the limits allow and from which the board is surely seen
  };

  /// @param problem       with the observations of an earlier run, which this one adds to, or
  ///                      without any
  /// @param T_base_start  flange pose from which the board is seen
  /// @throws std::invalid_argument  bad params or problem; the limits do not allow the start: why
  CalibrationRun(const HandEyeProblem& problem, const HandEyeParams& solver,
                 const RunParams& params, const Eigen::Isometry3d& T_base_start);

  /// Where to go for the next picture; the first one is the start itself. Nothing: see end().
  std::optional<Eigen::Isometry3d> next();
  End end() const { return end_; }

  /// The next pose on the way there, from where the robot really stands; nothing once it has
  /// arrived, and where the limits allow no way on.
  std::optional<Eigen::Isometry3d> step();
  bool isThere() const { return way_.empty(); }
  /// Makes the start the goal of step(). @return  false where the limits allow no way back
  bool headBack();
  /// What is left of the way, for people to look at.
  const std::vector<Eigen::Isometry3d>& way() const { return way_; }
  /// Whether that pose was chosen from a solution, and not as one of the first, small moves.
  bool isLarge() const { return is_large_; }
  /// Where the robot stands now. @throws std::runtime_error  outside the limits: why
  void arrived(const Eigen::Isometry3d& T_base_flange);

  // What came of the pose that next() gave.
  /// The robot did not go there, or not all the way: it refused this pose.
  void refused(const Eigen::Isometry3d& T_base_flange);
  void lost();  ///< it went, and the board was not seen
  /// A picture from where there is one already (isKnown()) counts once.
  /// @throws std::runtime_error  camera or board are seen to be further from the flange than
  /// mounted_radius_m
  void seen(const Observation& observation);
  bool isKnown(const Eigen::Isometry3d& T_base_flange) const;
  /// Since the robot last moved.
  int refusalsInARow() const { return refusals_; }

  /// The verdict over all that was seen.
  HandEyeResult result() const { return solveHandEye(problem_, solver_); }

  const HandEyeProblem& problem() const { return problem_; }
  /// Provisional; nothing before the first small moves are done.
  const std::optional<HandEyeResult>& solution() const { return solution_; }
  int attempts() const { return attempts_; }
  const std::vector<PlannedPose>& poses() const { return poses_; }  ///< all asked for, in order
  const MotionLimits& limits() const { return limits_; }

 private:
  End whyEnough() const;
  std::optional<Eigen::Isometry3d> firstMove();
  std::optional<Eigen::Isometry3d> bestMove();
  /// Sets way_. @return  whether the target may be gone to
  bool findWay(const Eigen::Isometry3d& T_base_target);
  void update();
  void updateMounted();
  bool isNearRefused(const Eigen::Isometry3d& T_base_flange, double metres, double radians) const;

  HandEyeProblem problem_;
  const HandEyeParams solver_;
  const RunParams params_;
  const Eigen::Isometry3d T_base_start_;
  MotionLimits limits_;
  Eigen::Isometry3d T_base_here_;
  const std::size_t earlier_views_;
  std::mt19937 random_;
  int attempts_ = 0, first_moves_ = 0, refusals_ = 0;
  bool is_large_ = false;
  End end_ = End::kNone;
  double turn_;           // of the first moves, radians; smaller once the board was lost
  double caution_ = 1.0;  // factor on the uncertainty; larger once the board was lost
  std::vector<PlannedPose> poses_;
  std::vector<Eigen::Isometry3d> way_;
  std::vector<Eigen::Isometry3d> refused_;
  std::optional<HandEyeResult> solution_;  // provisional
};

}  // namespace planar_bin_picking
