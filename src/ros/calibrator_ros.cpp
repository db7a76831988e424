// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator_ros.h"

#include "convert.h"
#include "load_params.h"
#include "names.h"
#include "plan_markers.h"
#include "transforms.h"

#include <ros/console.h>
#include <std_msgs/String.h>
#include <visualization_msgs/MarkerArray.h>

#include <sstream>

namespace planar_bin_picking_ros {

using planar_bin_picking::BoardSighting;
using planar_bin_picking::CalibrationRun;
using planar_bin_picking::HandEyeProblem;
using planar_bin_picking::HandEyeResult;
using planar_bin_picking::Mounting;
using planar_bin_picking::Verdict;

namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;

/// ~abort ends the run with this.
struct Stopped : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What the solver cannot know: poses that gave no picture of the board.
void explain(const CalibrationRun& run, HandEyeResult* result) {
  using State = planar_bin_picking::PlannedPose::State;
  int refused = 0, lost = 0;
  for (const auto& pose : run.poses()) {
    refused += pose.state == State::kRefused ? 1 : 0;
    lost += pose.state == State::kLost ? 1 : 0;
  }
  const std::string of = " of " + std::to_string(run.poses().size()) + " poses";
  if (refused > 0) {
    result->reasons.push_back("the robot refused " + std::to_string(refused) + of +
                              "; start elsewhere, or correct the workspace");
  }
  if (lost > 0) {
    result->reasons.push_back("no sharp board was seen from " + std::to_string(lost) + of +
                              "; has it been moved or covered, is there light?");
  }
}

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
      robot_(nh, params_.base_frame, params_.speed_scale, params_.move_timeout),
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
  if (running_) {
    stop_ = true;
    robot_.stopNow();
  }
  source_.close();
  if (thread_.joinable()) thread_.join();
  services_.clear();
  call_spinner_.stop();
  image_spinner_.stop();
}

void CalibratorRos::setStatus(const std::string& text) {
  const std::lock_guard<std::mutex> lock(status_mutex_);
  ROS_INFO_STREAM("status: " << text);
  std_msgs::String message;
  message.data = text;
  status_.publish(message);
}

void CalibratorRos::checkStop() const {
  if (stop_) throw Stopped("ABORTED: stopped by ~abort; nothing was saved");
}

bool CalibratorRos::start(Request&, Response& response) {
  const std::lock_guard<std::mutex> lock(start_mutex_);
  if (running_) {
    response.success = false;
    response.message = "a calibration is under way; ~abort ends it";
    return true;
  }
  if (thread_.joinable()) thread_.join();
  {
    const std::lock_guard<std::mutex> status_lock(status_mutex_);
    poses_so_far_ = summarize({});
  }
  stop_ = false;
  running_ = true;
  thread_ = std::thread(&CalibratorRos::runThread, this);
  response.success = true;
  response.message = "started; see ~status";
  return true;
}

bool CalibratorRos::abort(Request&, Response& response) {
  if (!running_) {
    response.success = false;
    response.message = "no calibration is under way";
    return true;
  }
  stop_ = true;
  response.success = robot_.stopNow();
  response.message = response.success ? "stopped" : "the robot did not confirm that it stopped";
  return true;
}

void CalibratorRos::runThread() {
  std::string status;
  try {
    status = calibrate();
  } catch (const Stopped& stopped) {
    status = stopped.what();
  } catch (const std::exception& error) {
    status = stop_ ? "ABORTED: stopped by ~abort; nothing was saved"
                   : std::string("FAILED: ") + error.what();
  }
  // Whoever reads the last status may start anew.
  running_ = false;
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

CalibratorRos::Look CalibratorRos::look() {
  Look look;
  look.frame = source_.await(ros::Time(), ros::Duration(params_.image_timeout));
  checkStop();
  const std_msgs::Header& header = look.frame.image->header;
  const LookupResult flange =
      lookup(tf_buffer_, params_.base_frame, params_.flange_frame, header.stamp,
             std::chrono::duration<double>(params_.tf_timeout));
  if (!flange.T_target_source) {
    throw std::runtime_error("tf has no way from " + params_.base_frame + " to " +
                             params_.flange_frame + " at the image's stamp (" + flange.reason +
                             "); check base_frame, flange_frame and the robot's driver");
  }
  look.T_base_flange = *flange.T_target_source;
  look.image = toGrey(look.frame.image);
  look.board = planar_bin_picking::findBoard(look.image, board_, params_.blur_max_px);
  camera_frame_ = header.frame_id;
  return look;
}

std::string CalibratorRos::calibrate() {
  const Look first = look();
  if (first.board.status != BoardSighting::Status::kFound) {
    const std::string other = planar_bin_picking::findOtherBoard({first.image}, board_);
    throw std::runtime_error(
        first.board.status == BoardSighting::Status::kBlurred
            ? "the board is blurred at the start; focus the camera, light the board"
        : other.empty()
            ? "the start shows no board of " + params_.board +
                  " inner corners; bring it into view, light it, count its inner corners"
            : "the start shows a board of " + other + " inner corners, not of " + params_.board +
                  "; set board to " + other);
  }
  CalibrationRun run(emptyProblem(first), params_.solver, params_.run, first.T_base_flange);
  bool move = false;  // the first picture is taken where the robot stands
  while (const auto target = run.next()) {
    checkStop();
    setStatus("running: pose " + std::to_string(run.attempts()) + ", " +
              std::to_string(run.problem().sightings.size()) + " pictures so far");
    show(run);
    visit(*target, move, &run);
    move = true;
  }
  show(run);
  robot_.move(first.T_base_flange, stop_);
  setStatus("running: solving");
  HandEyeResult result = run.result();
  checkStop();
  if (result.verdict != Verdict::kGood) explain(run, &result);
  return save(run.problem(), result);
}

void CalibratorRos::show(const CalibrationRun& run) {
  const auto& solution = run.solution();
  markers_.publish(makePlanMarkers(params_.base_frame, params_.mountingValue(), run.poses(),
                                   solution ? &*solution : nullptr));
  const std::lock_guard<std::mutex> lock(status_mutex_);
  poses_so_far_ = summarize(run.poses());
}

void CalibratorRos::visit(const Eigen::Isometry3d& T_base_flange, bool move, CalibrationRun* run) {
  planar_bin_picking::MoveRobot::Response answer;
  if (move) {
    answer = robot_.move(T_base_flange, stop_);
    if (!answer.success) {
      ROS_WARN_STREAM("the robot did not go there ("
                      << (answer.reachable ? "reachable" : "not reachable")
                      << "): " << answer.message);
      run->refused();
      return;
    }
    ros::WallDuration(params_.settle).sleep();
  }
  checkStop();
  const Look seen = look();
  if (move) {
    const Eigen::Isometry3d off = fromMsg(answer.reached.pose).inverse() * seen.T_base_flange;
    const double mm = 1e3 * off.translation().norm();
    const double deg = kDegrees * planar_bin_picking::rotationAngle(off.linear());
    if (mm > params_.reached_mm || deg > params_.reached_deg) {
      std::ostringstream text;
      text << "tf is stale or of another frame: it has the flange " << mm << " mm and " << deg
           << " deg from where the robot says it stands";
      throw std::runtime_error(text.str());
    }
  }
  if (seen.board.status != BoardSighting::Status::kFound) {
    ROS_WARN_STREAM((seen.board.status == BoardSighting::Status::kBlurred ? "board blurred"
                                                                          : "board not seen"));
    run->lost();
    return;
  }
  run->seen({"picture " + std::to_string(run->problem().sightings.size() + 1), seen.T_base_flange,
             seen.board.corners});
}

std::string CalibratorRos::save(const HandEyeProblem& problem, const HandEyeResult& result) {
  planar_bin_picking::CalibrationNames names;
  names.camera_name = params_.camera_name;
  names.mount_frame =
      problem.mounting == Mounting::kEyeInHand ? params_.flange_frame : params_.base_frame;
  names.camera_frame = params_.camera_frame.empty() ? camera_frame_ : params_.camera_frame;
  planar_bin_picking::saveCalibration(params_.output_folder, problem, result, names);
  std::ostringstream status;
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
  try {
    if (running_) {
      const std::lock_guard<std::mutex> lock(status_mutex_);
      response.success = true;
      response.message = "under way; on ~plan_markers are " + poses_so_far_;
      return true;
    }
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

bool CalibratorRos::addSample(Request&, Response& response) {
  const std::lock_guard<std::mutex> lock(sample_mutex_);
  try {
    if (running_) throw std::runtime_error("a calibration is under way; ~abort ends it");
    const Look seen = look();
    response.success = seen.board.status == BoardSighting::Status::kFound;
    if (response.success) {
      if (!samples_) samples_ = std::make_unique<HandEyeProblem>(emptyProblem(seen));
      auto& sightings = samples_->sightings;
      sightings.push_back({"sample " + std::to_string(sightings.size() + 1), seen.T_base_flange,
                           seen.board.corners});
    }
    response.message =
        (response.success ? "taken"
                          : "no sharp board of " + params_.board + " inner corners in view") +
        std::string("; there are ") + std::to_string(samples_ ? samples_->sightings.size() : 0) +
        " samples; ~finish solves";
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

bool CalibratorRos::finish(Request&, Response& response) {
  const std::lock_guard<std::mutex> lock(sample_mutex_);
  try {
    if (!samples_) throw std::runtime_error("there are no samples; take some with ~add_sample");
    const HandEyeResult result = planar_bin_picking::solveHandEye(*samples_, params_.solver);
    response.message = save(*samples_, result);
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
