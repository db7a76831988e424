// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Everything below `~calibrator`; see config/calibrator.yaml. Defaults stand in the structs alone.

#include "planar_bin_picking/calibrate/board/find_board.h"
#include "planar_bin_picking/calibrate/calibration_run.h"

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

namespace planar_bin_picking_ros {

struct CalibratorParams {
  std::string mounting = "eye_in_hand";  ///< or eye_to_hand
  std::string board = "9x6";             ///< inner corners
  double square = 0.0;                   ///< side of a square, metres; must be set
  std::string board_file;                ///< in place of these two: the board as YAML
  std::string base_frame = "base", flange_frame = "flange";
  std::string camera_frame;  ///< in the result; "" = the image's
  std::string camera_name = "camera";
  std::string output_folder;   ///< must be set
  bool fixed_camera = false;   ///< keep the intrinsics that camera_info has
  double speed_scale = 0.2;    ///< share of the robot's full speed
  double move_timeout = 60.0;  ///< s, wall time, for a move
  double stop_timeout = 3.0;   ///< s, wall time, for the robot to confirm that it stopped
  double image_timeout = 5.0;  ///< s, wall time
  double tf_timeout = 0.5;     ///< s, wall time: how much later than the image its tf may come in
  double settle = 0.3;         ///< s between standstill and the picture
  double blur_max_px = planar_bin_picking::kBlurMaxPx;  ///< wider edges: out of focus or moving
  double reached_mm = 3.0;          ///< target, robot's answer and tf may differ by this, and
  double reached_deg = 0.5;         ///< this; more ends the run
  bool step = false;                ///< ~next is asked for before each move
  bool confirm_first_large = true;  ///< and before the first move that is no small one
  planar_bin_picking::HandEyeParams solver;
  planar_bin_picking::RunParams run;

  /// Calls visit(key, member, min, max) for numbers and visit(key, member) for all else.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("mounting", self.mounting);
    visit("board", self.board);
    visit("square", self.square, 0.0, 10.0);
    visit("board_file", self.board_file);
    visit("base_frame", self.base_frame);
    visit("flange_frame", self.flange_frame);
    visit("camera_frame", self.camera_frame);
    visit("camera_name", self.camera_name);
    visit("output_folder", self.output_folder);
    visit("fixed_camera", self.fixed_camera, false, true);
    visit("speed_scale", self.speed_scale, 0.001, 1.0);
    visit("move_timeout", self.move_timeout, 0.1, 3600.0);
    visit("stop_timeout", self.stop_timeout, 0.1, 60.0);
    visit("image_timeout", self.image_timeout, 0.1, 3600.0);
    visit("tf_timeout", self.tf_timeout, 0.0, 60.0);
    visit("settle", self.settle, 0.0, 60.0);
    visit("blur_max_px", self.blur_max_px, 0.5, 50.0);
    visit("reached_mm", self.reached_mm, 0.01, 1000.0);
    visit("reached_deg", self.reached_deg, 0.01, 90.0);
    visit("step", self.step, false, true);
    visit("confirm_first_large", self.confirm_first_large, false, true);
    using planar_bin_picking::HandEyeParams;
    using planar_bin_picking::RunParams;
    HandEyeParams::fields(self.solver, [&](const std::string& key, auto& member, auto min,
                                           auto max) { visit("solver/" + key, member, min, max); });
    RunParams::fields(self.run, [&](const std::string& key, auto& member, auto min, auto max) {
      visit("run/" + key, member, min, max);
    });
    visit("run/planes", self.run.motion.planes);
  }

  planar_bin_picking::Mounting mountingValue() const;  ///< @pre validated
  /// @throws std::runtime_error  the board's file: what is wrong with it
  planar_bin_picking::Board boardValue() const;
};

/// @throws std::invalid_argument  naming the key, its value and what it must be
void validate(const CalibratorParams& params);

/// @param tree  as readTree returns it
CalibratorParams loadCalibratorParams(const XmlRpc::XmlRpcValue& tree);
std::string describe(const CalibratorParams& params);

}  // namespace planar_bin_picking_ros
