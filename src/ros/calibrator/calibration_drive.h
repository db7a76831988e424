// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One calibration by itself: goes where the run says, looks, and tells the run what came of it.

#include "calibrator/board_look.h"
#include "calibrator/robot_mover.h"
#include "planar_bin_picking/calibrate/calibration_run.h"

#include <functional>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

class CalibrationDrive {
 public:
  /// Whom it tells.
  struct Listener {
    std::function<void(const std::string& status)> say;
    /// The run's poses, and the way to the next one from where the robot stands.
    std::function<void(const planar_bin_picking::CalibrationRun&,
                       const std::vector<Eigen::Isometry3d>& way)>
        show;
    std::function<std::string(const Look&)> keep;  ///< each picture of the board; its name
  };

  /// @param first    taken where the robot stands: the start
  /// @param problem  with the observations of an earlier run, or without any
  /// @throws std::invalid_argument  the start is not allowed: why
  CalibrationDrive(const CalibratorParams& params, const BoardLook& board, RobotMover* robot,
                   Listener listener, const Look& first,
                   const planar_bin_picking::HandEyeProblem& problem);

  /// Drives until the run has enough, and back to the start.
  /// @return  why it did not come back, which costs no calibration, or ""
  /// @throws Stopped  somebody asked for it
  /// @throws std::runtime_error  robot, camera or tf are not as they should be
  std::string drive();

  const planar_bin_picking::CalibrationRun& run() const { return run_; }
  /// Of the last picture without the board; "" where all show it. Takes seconds.
  std::string whyLost() const;

 private:
  void visit(const Eigen::Isometry3d& T_base_target);
  /// @return  the pose that the robot refused, or towards which the limits allow no way
  std::optional<Eigen::Isometry3d> go();
  /// @return  false where the robot cannot go there
  bool goTo(const Eigen::Isometry3d& T_base_flange);
  std::string goBack();
  void confirm();
  std::vector<Eigen::Isometry3d> wayFromHere() const;
  std::string progress() const;

  const CalibratorParams& params_;
  const BoardLook& board_;
  RobotMover& robot_;
  const Listener listener_;
  const Look first_;
  planar_bin_picking::CalibrationRun run_;
  Eigen::Isometry3d T_base_here_;  // as the robot says
  bool is_confirmed_ = false;      // the first large move
  std::optional<Look> lost_;       // the last picture without the board
};

}  // namespace planar_bin_picking_ros
