// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a hand-eye calibration is given and what comes out: the types that the solver's units and
/// its users share. The model is stated in hand_eye.h.

#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/calibrate/board/board.h"
#include "planar_bin_picking/image/camera.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

enum class Mounting { kEyeInHand, kEyeToHand };

/// One picture of the board and where the robot stood.
struct Observation {
  std::string name;  ///< for messages
  Eigen::Isometry3d T_base_flange = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector2d> corners;  ///< pixels, one per corner of the board, or per id
  /// Which of the board's corners each is, where only a part of the board is seen; empty: all.
  std::vector<std::size_t> ids{};

  std::vector<Eigen::Vector3d> points(const Board& board) const { return board.points(ids); }
};

struct HandEyeProblem {
  Mounting mounting = Mounting::kEyeInHand;
  Board board;
  int width = 0, height = 0;  ///< of the images
  std::vector<Observation> observations;
  /// Held fixed where given; otherwise intrinsics and plumb_bob distortion are estimated.
  std::optional<Camera::Model> camera;
};

struct HandEyeParams {
  int min_views = 8;             ///< fewer usable views are refused; nearly equal ones count once
  double robot_sigma_mm = 0.0;   ///< accuracy of the robot's poses; 0 = estimated from the data
  double robot_sigma_deg = 0.0;  ///< likewise
  double axes_min_deg = 5.0;  ///< rotations about the second axis, RMS, below which it is refused
  double pair_angle_min_deg = 5.0;    ///< pairs of views turned by less say nothing about rotation
  double pair_angle_max_deg = 170.0;  ///< beyond, the axis of the turn is uncertain
  double wrong_pair_deg = 3.0;        ///< robot and board turn by angles that differ more: not used
  double robot_poor_mm = 1.0;         ///< noisier robots give POOR
  double robot_poor_deg = 0.2;
  double robot_refused_mm = 5.0;  ///< noisier robots are refused
  double robot_refused_deg = 1.0;
  double scale_tolerance = 0.02;  ///< relative error of the square that is refused
  double tolerance_mm = 1.0;      ///< a larger expected error is POOR
  double tolerance_deg = 0.2;
  double working_distance = 0.0;  ///< metres from the camera to the parts; 0 = as the boards were

  /// The robot turns about the base's z axis alone (SCARA, palletizer, gantry): pictures leave the
  /// camera's height open, and board_z closes it: how high the middle of the board's inner corners
  /// is, in the base's frame, or in the flange's for a board on the flange, and how sure that is.
  bool four_axis = false;
  double board_z = 0.0;  ///< metres
  double board_z_sigma_mm = 1.0;

  /// Calls visit(key, member, min, max) for every parameter.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("min_views", self.min_views, 4, 1000);
    visit("robot_sigma_mm", self.robot_sigma_mm, 0.0, 100.0);
    visit("robot_sigma_deg", self.robot_sigma_deg, 0.0, 10.0);
    visit("axes_min_deg", self.axes_min_deg, 0.0, 90.0);
    visit("pair_angle_min_deg", self.pair_angle_min_deg, 0.0, 90.0);
    visit("pair_angle_max_deg", self.pair_angle_max_deg, 90.0, 180.0);
    visit("wrong_pair_deg", self.wrong_pair_deg, 0.1, 90.0);
    visit("robot_poor_mm", self.robot_poor_mm, 0.0, 100.0);
    visit("robot_poor_deg", self.robot_poor_deg, 0.0, 10.0);
    visit("robot_refused_mm", self.robot_refused_mm, 0.0, 100.0);
    visit("robot_refused_deg", self.robot_refused_deg, 0.0, 10.0);
    visit("scale_tolerance", self.scale_tolerance, 0.001, 1.0);
    visit("tolerance_mm", self.tolerance_mm, 0.001, 1000.0);
    visit("tolerance_deg", self.tolerance_deg, 0.001, 90.0);
    visit("working_distance", self.working_distance, 0.0, 100.0);
    visit("four_axis", self.four_axis, false, true);
    visit("board_z", self.board_z, -100.0, 100.0);
    visit("board_z_sigma_mm", self.board_z_sigma_mm, 0.001, 100.0);
  }
};

/// Columns of the parameters that all views share, as in HandEyeResult::covariance.
enum SharedColumn { kIntrinsics = 0, kHandEye = 12, kBoard = 18, kSharedSize = 24 };

using SharedMatrix = Eigen::Matrix<double, kSharedSize, kSharedSize>;

enum class Verdict {
  kGood,     ///< below the tolerances, and nothing speaks against it
  kPoor,     ///< usable, with the stated expected error; reasons say what limits it
  kRefused,  ///< not to be used, nothing is saved; reasons say what is wrong
};
const char* nameOf(Verdict verdict);  ///< GOOD, POOR, REFUSED

/// A lens model that was tried: how well pictures that it was not made from fit it.
struct LensTrial {
  int coefficients = 0;      ///< 0, 1 (k1), 5 (plumb_bob), 8 (rational_polynomial)
  double held_out_px = 0.0;  ///< residual with each board placed freely
  bool is_chosen = false;
};

/// What became of one observation.
struct ViewResult {
  bool used = false;
  std::string why_not;                     ///< where it was not used
  std::vector<Eigen::Vector2d> residuals;  ///< seen minus predicted, pixels; empty where not used
  double rms_px = 0.0;    ///< of them, over both coordinates' sum of squares / corners
  double rms_mm = 0.0;    ///< the same at the board
  double floor_px = 0.0;  ///< the same with the board placed freely
  Vector6d correction = Vector6d::Zero();  ///< c of the robot pose
  Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
};

struct HandEyeResult {
  Verdict verdict = Verdict::kRefused;
  std::vector<std::string> reasons;    ///< empty where GOOD; the heaviest first
  std::vector<std::string> notes;      ///< what else to know, no flaw
  std::string transform_name;          ///< T_flange_camera or T_base_camera
  HandEyeParams params;                ///< that it was made and judged by
  std::vector<LensTrial> lens_trials;  ///< empty where the camera is given, or the views are few
  Eigen::Isometry3d T_mount_camera = Eigen::Isometry3d::Identity();  ///< mount: flange or base
  Eigen::Isometry3d T_other_board = Eigen::Isometry3d::Identity();   ///< other: base or flange
  Camera::Model camera;
  bool solved = false;  ///< the numbers below hold
  /// Of [fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6, xi of T_mount_camera, xi of T_other_board]; of a
  /// given camera: zero unless the pictures contradict it, then by how much.
  SharedMatrix covariance = SharedMatrix::Zero();
  double rms_px = 0.0;    ///< whole chain, with the corrected robot poses
  double chain_px = 0.0;  ///< whole chain, with the robot poses as they were reported
  /// Mean over the views of the whole chain's residual as the other views predict it, with the
  /// robot pose as it was reported; 0 with too few views.
  double held_out_px = 0.0;
  double pnp_floor_px = 0.0;  ///< each board placed freely: what the corners allow
  /// Where the pictures contradict the given camera: about the residual that one estimated from
  /// them would leave; else 0.
  double own_camera_px = 0.0;
  double sigma_px = 0.0;                   ///< estimated noise of a corner's coordinate
  double robot_mm = 0.0, robot_deg = 0.0;  ///< estimated noise of a robot pose, per axis
  double square_ratio = 0.0, square_ratio_sigma = 0.0;  ///< square that fits / square stated
  double axes_deg = 0.0;                                ///< RMS rotation about the second axis
  /// RMS error of the pose of a part at the working distance, in the mount's frame, over five
  /// places in the image: the calibration's share, with a robot that goes where it says.
  double expected_error_mm = 0.0, expected_error_deg = 0.0;
  double working_distance = 0.0;  ///< that it holds for
  /// The same with the robot's own noise: of the pose that a camera on the flange looks from, and
  /// of the pose that the flange goes to.
  double with_robot_mm = 0.0, with_robot_deg = 0.0;
  /// How far T_mount_camera moves at most when one view is left out.
  double leave_one_out_mm = 0.0, leave_one_out_deg = 0.0;
  std::string leave_one_out_view;  ///< without which it moves farthest
  int views_used = 0;
  std::vector<ViewResult> views;  ///< one per observation
};

/// Everything that the caller could get wrong. @throws std::invalid_argument  which one and why
void validate(const HandEyeProblem& problem);

/// @throws std::invalid_argument  the first field out of its range: key, value, allowed range
void validate(const HandEyeParams& params);

}  // namespace planar_bin_picking
