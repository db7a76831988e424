// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibrator_ros.h"

#include "calibrator/calibrator_checks.h"
#include "calibrator/plan_markers.h"
#include "locator/load_params.h"
#include "shared/convert.h"
#include "shared/names.h"
#include "shared/transforms.h"

#include <ros/console.h>
#include <std_msgs/String.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <sstream>

namespace planar_bin_picking_ros {

using planar_bin_picking::BoardObservation;
using planar_bin_picking::CalibrationRun;
using planar_bin_picking::HandEyeProblem;
using planar_bin_picking::HandEyeResult;
using planar_bin_picking::Mounting;
using planar_bin_picking::Verdict;

namespace {

/// s; what is published last needs it to reach those who listen, before the node goes.
constexpr double kLastWord = 0.2;

ros::NodeHandle onQueue(ros::NodeHandle nh, ros::CallbackQueue* queue) {
  nh.setCallbackQueue(queue);
  return nh;
}

}  // namespace

CalibratorRos::CalibratorRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh)
    : params_(loadCalibratorParams(readTree(pnh, kCalibratorParams))),
      board_(planar_bin_picking::parseBoard(params_.board, params_.square)),
      image_nh_(onQueue(nh, &image_queue_)),
      call_pnh_(onQueue(pnh, &call_queue_)),
      tf_listener_(tf_buffer_),
      source_(image_nh_, pnh),
      robot_(nh,
             {params_.base_frame, params_.speed_scale, params_.move_timeout, params_.stop_timeout}),
      image_spinner_(1, &image_queue_),
      call_spinner_(3, &call_queue_) {
  ROS_INFO_STREAM("calibrator:" << describe(params_));
  status_ = call_pnh_.advertise<std_msgs::String>(kStatusTopic, 10, true);
  markers_ = call_pnh_.advertise<visualization_msgs::MarkerArray>(kPlanTopic, 1, true);
  services_ = {call_pnh_.advertiseService(kStartService, &CalibratorRos::start, this),
               call_pnh_.advertiseService(kAbortService, &CalibratorRos::abort, this),
               call_pnh_.advertiseService(kPlanService, &CalibratorRos::plan, this),
               call_pnh_.advertiseService(kAddSampleService, &CalibratorRos::addSample, this),
               call_pnh_.advertiseService(kFinishService, &CalibratorRos::finish, this)};
  image_spinner_.start();
  call_spinner_.start();
  setStatus("ready: call ~start, with the board in view and the robot free to move");
}

CalibratorRos::~CalibratorRos() {
  const bool is_running = task_.close([this] {
    robot_.forbidMoves();
    source_.close();
  });
  if (is_running) robot_.stopNow();
  for (ros::ServiceServer& service : services_) service.shutdown();
  call_spinner_.stop();
  if (thread_.joinable()) thread_.join();
  if (is_running) ros::WallDuration(kLastWord).sleep();
  image_spinner_.stop();
}

void CalibratorRos::setStatus(const std::string& text) {
  const std::lock_guard<std::mutex> lock(status_mutex_);
  ROS_INFO_STREAM("status: " << text);
  std_msgs::String message;
  message.data = text;
  status_.publish(message);
}

std::string CalibratorRos::stoppedStatus() {
  if (robot_.isStopConfirmed()) return "ABORTED: the robot stopped as asked; nothing was saved";
  ROS_FATAL_STREAM("the stop was not confirmed: the robot may be moving; use its own stop");
  return "FAILED: stop was not confirmed: the robot may be moving; use its own stop; nothing was "
         "saved";
}

CalibratorTask::Hold CalibratorRos::begin(CalibratorTask::Kind kind) {
  return task_.begin(kind, [this, kind] {
    source_.open();
    robot_.reset(kind == CalibratorTask::Kind::kRun);
  });
}

bool CalibratorRos::start(Request&, Response& response) {
  try {
    auto hold = begin(CalibratorTask::Kind::kRun);
    if (thread_.joinable()) thread_.join();  // of the run before, which says its last word
    {
      const std::lock_guard<std::mutex> status_lock(status_mutex_);
      poses_so_far_ = summarize({});
    }
    thread_ = std::thread(&CalibratorRos::runThread, this, std::move(hold));
    response.success = true;
    response.message = "started; see ~status";
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

bool CalibratorRos::abort(Request&, Response& response) {
  // From here on no move begins, and nothing is waited for.
  const bool is_running = task_.duringRun([this] {
    robot_.forbidMoves();
    source_.close();
  });
  response.success = is_running && robot_.stopNow();
  response.message = response.success ? "stopped"
                     : is_running     ? "stop was not confirmed: the robot may be moving; use its "
                                        "own stop"
                                      : "no calibration is under way";
  return true;
}

void CalibratorRos::runThread(CalibratorTask::Hold hold) {
  std::string status;
  try {
    status = calibrate();
  } catch (const std::exception& error) {
    // Where an image was awaited it failed because it was stopped.
    status = robot_.isAskedToStop() ? stoppedStatus() : std::string("FAILED: ") + error.what();
  }
  // Whoever reads the last status may start anew.
  hold.release();
  setStatus(status);
}

HandEyeProblem CalibratorRos::emptyProblem(const Look& look) const {
  HandEyeProblem problem;
  problem.mounting = params_.mountingValue();
  problem.board = board_;
  problem.width = look.image.cols;
  problem.height = look.image.rows;
  if (params_.fixed_camera) problem.camera = toCamera(*look.frame.info, *look.frame.image).model();
  return problem;
}

Eigen::Isometry3d CalibratorRos::flangeAt(const ros::Time& stamp) const {
  constexpr double kSlice = 0.1;  // s; so long a stop waits at most
  for (double left = params_.tf_timeout;; left -= kSlice) {
    robot_.checkStop();
    const LookupResult flange =
        lookup(tf_buffer_, params_.base_frame, params_.flange_frame, stamp,
               std::chrono::duration<double>(std::clamp(left, 0.0, kSlice)));
    if (flange.T_target_source) return *flange.T_target_source;
    if (left > kSlice) continue;
    throw std::runtime_error("tf has no way from " + params_.base_frame + " to " +
                             params_.flange_frame + " at the image's stamp (" + flange.reason +
                             "); check base_frame, flange_frame and the robot's driver");
  }
}

CalibratorRos::Look CalibratorRos::look() {
  Look look;
  look.frame = source_.await(ros::Time(), ros::Duration(params_.image_timeout));
  look.T_base_flange = flangeAt(look.frame.image->header.stamp);
  look.image = toGrey(look.frame.image);
  look.board = planar_bin_picking::findBoard(look.image, board_, params_.blur_max_px);
  return look;
}

std::string CalibratorRos::calibrate() {
  planar_bin_picking::checkCalibrationFolder(params_.output_folder);
  const Look first = look();
  if (first.board.status != BoardObservation::Status::kFound) {
    throw std::runtime_error(whyNoBoard(first.board, first.image, board_));
  }
  CalibrationRun run(emptyProblem(first), params_.solver, params_.run, first.T_base_flange);
  bool move = false;  // the first picture is taken where the robot stands
  while (const auto target = run.next()) {
    robot_.checkStop();
    setStatus("running: pose " + std::to_string(run.attempts()) + ", " +
              std::to_string(run.problem().observations.size()) + " pictures so far");
    show(run);
    visit(*target, move, first, &run);
    move = true;
  }
  show(run);
  const std::string back = goBack(first.T_base_flange);
  setStatus("running: solving");
  HandEyeResult result = run.result();
  robot_.checkStop();
  if (result.verdict != Verdict::kGood) explain(run, &result);
  return save(run.problem(), result, first.frame.image->header.frame_id) + back;
}

bool CalibratorRos::goTo(const Eigen::Isometry3d& T_base_flange,
                         Eigen::Isometry3d* T_base_reached) {
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
  *T_base_reached = fromMsg(answer.reached.pose);
  checkNear(T_base_flange, *T_base_reached, params_, "the robot says that it stands",
            "where it was sent");
  return true;
}

std::string CalibratorRos::goBack(const Eigen::Isometry3d& T_base_start) {
  std::string reason = "the robot cannot go there";
  try {
    if (robot_.move(T_base_start).success) return "";
  } catch (const Stopped&) {
    throw;
  } catch (const std::exception& error) {
    reason = error.what();
  }
  ROS_ERROR_STREAM("the robot did not return to the start: " << reason);
  return "; the robot did not return to the start: " + reason;
}

void CalibratorRos::show(const CalibrationRun& run) {
  const auto& solution = run.solution();
  markers_.publish(makePlanMarkers(params_.base_frame, params_.mountingValue(), run.poses(),
                                   solution ? &*solution : nullptr));
  const std::lock_guard<std::mutex> lock(status_mutex_);
  poses_so_far_ = summarize(run.poses());
}

void CalibratorRos::visit(const Eigen::Isometry3d& T_base_flange, bool move, const Look& first,
                          CalibrationRun* run) {
  Eigen::Isometry3d T_base_reached = first.T_base_flange;
  if (move) {
    if (!goTo(T_base_flange, &T_base_reached)) {
      run->refused();
      return;
    }
    robot_.pause(params_.settle);
  }
  const Look seen = look();
  checkSameCamera(first.frame, seen.frame);
  checkNear(T_base_reached, seen.T_base_flange, params_,
            "tf is stale or of another frame: it has the flange",
            "where the robot says that it stands");
  if (seen.board.status != BoardObservation::Status::kFound) {
    ROS_WARN_STREAM((seen.board.status == BoardObservation::Status::kBlurred ? "board blurred"
                                                                             : "board not seen"));
    run->lost();
    return;
  }
  run->seen({"picture " + std::to_string(run->problem().observations.size() + 1),
             seen.T_base_flange, seen.board.corners});
}

std::string CalibratorRos::save(const HandEyeProblem& problem, const HandEyeResult& result,
                                const std::string& camera_frame) {
  planar_bin_picking::CalibrationNames names;
  names.camera_name = params_.camera_name;
  names.mount_frame =
      problem.mounting == Mounting::kEyeInHand ? params_.flange_frame : params_.base_frame;
  names.camera_frame = params_.camera_frame.empty() ? camera_frame : params_.camera_frame;
  planar_bin_picking::saveCalibration(params_.output_folder, problem, result, names);
  std::ostringstream status;
  status.imbue(std::locale::classic());
  status << nameOf(result.verdict) << ":";
  if (result.verdict != Verdict::kRefused) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = ros::Time::now();
    transform.header.frame_id = names.mount_frame;
    transform.child_frame_id = names.camera_frame;
    transform.transform = toTransformMsg(result.T_mount_camera);
    broadcaster_.sendTransform(transform);
    status << " expected error " << result.expected_error_mm << " mm and "
           << result.expected_error_deg << " deg with " << result.views_used << " views;";
  }
  for (const std::string& reason : result.reasons) status << " " << reason << ";";
  status << " see " << params_.output_folder << "/report.html";
  return status.str();
}

bool CalibratorRos::plan(Request&, Response& response) {
  const auto say = [&] {
    const std::lock_guard<std::mutex> lock(status_mutex_);
    response.success = true;
    response.message = "under way; on ~plan_markers are " + poses_so_far_;
  };
  if (task_.duringRun(say)) return true;
  try {
    const auto hold = begin(CalibratorTask::Kind::kPlan);
    const Look first = look();
    CalibrationRun run(emptyProblem(first), params_.solver, params_.run, first.T_base_flange);
    // Later poses depend on what is seen: these are the first ones.
    for (int i = 0; i < 6 && run.next(); ++i) {
    }
    show(run);
    response.success = true;
    response.message = "the first " + std::to_string(run.poses().size()) +
                       " poses are on ~plan_markers; later ones follow from what is seen";
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

void CalibratorRos::keep(const Look& seen) {
  if (!samples_) samples_ = std::make_unique<Samples>(Samples{emptyProblem(seen), seen.frame});
  checkSameCamera(samples_->first, seen.frame);
  auto& observations = samples_->problem.observations;
  observations.push_back({"sample " + std::to_string(observations.size() + 1), seen.T_base_flange,
                          seen.board.corners});
}

bool CalibratorRos::addSample(Request&, Response& response) {
  try {
    const auto hold = begin(CalibratorTask::Kind::kAddSample);
    const Look seen = look();
    response.success = seen.board.status == BoardObservation::Status::kFound;
    if (response.success) keep(seen);
    response.message =
        (response.success ? "taken"
                          : "no sharp board of " + params_.board + " inner corners in view") +
        std::string("; there are ") +
        std::to_string(samples_ ? samples_->problem.observations.size() : 0) +
        " samples; ~finish solves";
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

bool CalibratorRos::finish(Request&, Response& response) {
  try {
    const auto hold = begin(CalibratorTask::Kind::kFinish);
    if (!samples_) throw std::runtime_error("there are no samples; take some with ~add_sample");
    const HandEyeProblem& problem = samples_->problem;
    const HandEyeResult result = planar_bin_picking::solveHandEye(problem, params_.solver);
    response.message = save(problem, result, samples_->first.image->header.frame_id);
    response.success = result.verdict != Verdict::kRefused;
    if (response.success) samples_.reset();
    setStatus(response.message);
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

}  // namespace planar_bin_picking_ros
