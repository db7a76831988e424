// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibration_drive.h"

#include "calibrator/calibrator_checks.h"
#include "calibrator/plan_markers.h"
#include "shared/convert.h"

#include <ros/console.h>

#include <algorithm>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::BoardObservation;
using planar_bin_picking::HandEyeProblem;

namespace {

/// s; after a pose that the robot refused, times the refusals in a row, up to the second one.
constexpr double kRefusalPause = 0.5, kRefusalPauseMax = 3.0;

}  // namespace

CalibrationDrive::CalibrationDrive(const CalibratorParams& params, const BoardLook& board,
                                   RobotMover* robot, Listener listener, const Look& first,
                                   const HandEyeProblem& problem)
    : params_(params),
      board_(board),
      robot_(*robot),
      listener_(std::move(listener)),
      first_(first),
      run_(problem, params.solver, params.run, first.T_base_flange),
      T_base_here_(first.T_base_flange) {}

std::string CalibrationDrive::progress() const {
  return "pose " + std::to_string(run_.attempts()) + ", " +
         std::to_string(run_.problem().observations.size()) + " pictures so far";
}

std::vector<Eigen::Isometry3d> CalibrationDrive::wayFromHere() const {
  std::vector<Eigen::Isometry3d> way{T_base_here_};
  way.insert(way.end(), run_.way().begin(), run_.way().end());
  return way;
}

std::string CalibrationDrive::drive() {
  while (const auto target = run_.next()) {
    robot_.checkStop();
    listener_.say("running: " + progress());
    listener_.show(run_, wayFromHere());
    visit(*target);
  }
  const std::string back = goBack();
  listener_.show(run_, {});
  return back;
}

void CalibrationDrive::confirm() {
  const bool is_first_large = params_.confirm_first_large && run_.isLarge() && !is_confirmed_;
  if (!params_.step && !is_first_large) return;
  robot_.awaitGo([this] {
    listener_.say("waiting: " + progress() + "; the next way leads " + describeWay(wayFromHere()) +
                  "; look at ~plan_markers, then call ~next to go, or ~abort");
  });
  is_confirmed_ = is_confirmed_ || is_first_large;
  listener_.say("running: " + progress());
}

bool CalibrationDrive::goTo(const Eigen::Isometry3d& T_base_flange) {
  const auto answer = robot_.move(T_base_flange);
  if (!answer.success) {
    ROS_WARN_STREAM("the robot cannot go there: " << answer.message);
    return false;
  }
  const std::string& frame = answer.reached.header.frame_id;
  if (frame != params_.base_frame) {
    throw std::runtime_error("the robot says in frame \"" + frame + "\" where it stands, must be " +
                             params_.base_frame + ", as in the request; correct its adapter");
  }
  const Eigen::Isometry3d T_base_reached = fromMsg(answer.reached.pose);
  checkNear(T_base_flange, T_base_reached, params_, "the robot says that it stands",
            "where it was sent");
  run_.arrived(T_base_reached);
  T_base_here_ = T_base_reached;
  return true;
}

std::optional<Eigen::Isometry3d> CalibrationDrive::go() {
  while (const auto pose = run_.step()) {
    confirm();
    if (!goTo(*pose)) return pose;
  }
  if (run_.isThere()) return std::nullopt;
  ROS_WARN_STREAM("the limits allow no way on from where the robot stands");
  return run_.way().back();
}

void CalibrationDrive::visit(const Eigen::Isometry3d& T_base_target) {
  const bool is_move = !run_.way().empty();
  if (const auto refused = go()) {
    run_.refused(*refused);
    robot_.pause(std::min(kRefusalPauseMax, kRefusalPause * run_.refusalsInARow()));
    return;
  }
  if (is_move) robot_.pause(params_.settle);
  const Look seen = board_.take();
  checkSameCamera(first_.frame, seen.frame);
  checkNear(T_base_here_, seen.T_base_flange, params_,
            "tf is stale or of another frame: it has the flange",
            "where the robot says that it stands");
  if (seen.board.status != BoardObservation::Status::kFound) {
    ROS_WARN_STREAM((seen.board.status == BoardObservation::Status::kBlurred ? "board blurred"
                                                                             : "board not seen")
                    << " from [" << T_base_target.translation().transpose() << "]");
    lost_ = seen;
    run_.lost();
    return;
  }
  const bool is_known = run_.isKnown(seen.T_base_flange);
  run_.seen({is_known ? "" : listener_.keep(seen), seen.T_base_flange, seen.board.corners,
             seen.board.ids});
}

std::string CalibrationDrive::whyLost() const {
  return lost_ ? whyNoBoard(lost_->board, lost_->image, board_.board()) : "";
}

std::string CalibrationDrive::goBack() {
  std::string reason;
  try {
    if (!run_.headBack()) {
      reason = "the limits allow no way back";
    } else if (go()) {
      reason = "the robot cannot go there";
    }
  } catch (const Stopped&) {
    throw;
  } catch (const std::exception& error) {
    reason = error.what() + robot_.stopAfterFailure();
  }
  if (reason.empty()) return "";
  ROS_ERROR_STREAM("the robot did not return to the start: " << reason);
  return "; the robot did not return to the start: " + reason;
}

}  // namespace planar_bin_picking_ros
