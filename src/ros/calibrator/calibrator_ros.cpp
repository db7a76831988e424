// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibrator_ros.h"

#include "calibrator/calibrator_checks.h"
#include "calibrator/plan_markers.h"
#include "shared/convert.h"
#include "shared/convert_camera.h"
#include "shared/names.h"
#include "shared/param_reader.h"
#include "shared/transforms.h"

#include <ros/console.h>
#include <std_msgs/String.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <filesystem>
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

/// What a call does; what it throws is its answer.
template <class Response, class Act>
bool answer(Response* response, const Act& act) {
  try {
    act();
  } catch (const std::exception& error) {
    response->success = false;
    response->message = error.what();
  }
  return true;
}

ros::NodeHandle onQueue(ros::NodeHandle nh, ros::CallbackQueue* queue) {
  nh.setCallbackQueue(queue);
  return nh;
}

}  // namespace

CalibratorRos::CalibratorRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh)
    : params_(loadCalibratorParams(readTree(pnh, kCalibratorParams))),
      image_nh_(onQueue(nh, &image_queue_)),
      call_pnh_(onQueue(pnh, &call_queue_)),
      tf_listener_(tf_buffer_),
      source_(image_nh_, pnh),
      robot_(nh,
             {params_.base_frame, params_.speed_scale, params_.move_timeout, params_.stop_timeout}),
      board_(params_, &source_, &tf_buffer_, [this] { robot_.checkStop(); }),
      samples_(params_),
      verifier_(params_),
      image_spinner_(1, &image_queue_),
      call_spinner_(3, &call_queue_) {
  ROS_INFO_STREAM("calibrator:" << describe(params_));
  status_ = call_pnh_.advertise<std_msgs::String>(kStatusTopic, 10, true);
  markers_ = call_pnh_.advertise<visualization_msgs::MarkerArray>(kPlanTopic, 1, true);
  const auto serve = [this](const char* name, auto method) {
    services_.push_back(call_pnh_.advertiseService(name, method, this));
  };
  serve(kStartService, &CalibratorRos::start);
  serve(kAbortService, &CalibratorRos::abort);
  serve(kNextService, &CalibratorRos::next);
  serve(kPlanService, &CalibratorRos::plan);
  serve(kAddViewsService, &CalibratorRos::addViews);
  serve(kAddSampleService, &CalibratorRos::addSample);
  serve(kRemoveSampleService, &CalibratorRos::removeSample);
  serve(kListSamplesService, &CalibratorRos::listSamples);
  serve(kLoadSamplesService, &CalibratorRos::loadSamples);
  serve(kFinishService, &CalibratorRos::finish);
  serve(kVerifyService, &CalibratorRos::verify);
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
  if (robot_.isStopConfirmed())
    return "ABORTED: the robot stopped as asked; no calibration was saved";
  ROS_FATAL_STREAM("the stop was not confirmed: the robot may be moving; use its own stop");
  return "FAILED: stop was not confirmed: the robot may be moving; use its own stop; no "
         "calibration was saved";
}

CalibratorTask::Hold CalibratorRos::begin(CalibratorTask::Kind kind) {
  return task_.begin(kind, [this, kind] {
    source_.open();
    robot_.reset(kind == CalibratorTask::Kind::kRun);
  });
}

bool CalibratorRos::startRun(bool adds, Response& response) {
  return answer(&response, [&] {
    auto hold = begin(CalibratorTask::Kind::kRun);
    if (thread_.joinable()) thread_.join();  // of the run before, which says its last word
    {
      const std::lock_guard<std::mutex> status_lock(status_mutex_);
      poses_so_far_ = summarize({});
    }
    thread_ = std::thread(&CalibratorRos::runThread, this, std::move(hold), adds);
    response.success = true;
    response.message = "started; see ~status";
  });
}

bool CalibratorRos::start(Request&, Response& response) { return startRun(false, response); }

bool CalibratorRos::addViews(Request&, Response& response) { return startRun(true, response); }

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

void CalibratorRos::runThread(CalibratorTask::Hold hold, bool adds) {
  std::string status;
  try {
    status = calibrate(adds);
  } catch (const std::exception& error) {
    // Where an image was awaited it failed because it was stopped.
    status = robot_.isAskedToStop()
                 ? stoppedStatus()
                 : "FAILED: " + std::string(error.what()) + robot_.stopAfterFailure();
    status += samples_.keptText();
  }
  // Whoever reads the last status may start anew.
  hold.release();
  setStatus(status);
}

CalibrationDrive::Listener CalibratorRos::listener() {
  return {[this](const std::string& status) { setStatus(status); },
          [this](const CalibrationRun& run, const std::vector<Eigen::Isometry3d>& way) {
            show(run, way);
          },
          [this](const Look& look) { return samples_.add(look, board_.problemFor(look)); }};
}

void CalibratorRos::haveSamples(const Look& look) {
  if (samples_.isEmpty()) samples_.load();
  checkCamera(samples_.set(), look);
}

std::string CalibratorRos::calibrate(bool adds) {
  planar_bin_picking::checkCalibrationFolder(params_.output_folder);
  const Look first = board_.takeWithBoard();
  HandEyeProblem problem = board_.problemFor(first);
  if (adds) {
    haveSamples(first);
    problem.observations = samples_.set().problem.observations;
  }
  CalibrationDrive drive(params_, board_, &robot_, listener(), first, problem);
  if (!adds) samples_.begin(problem, first.frame);
  const std::string back = drive.drive();
  setStatus("running: solving");
  HandEyeResult result = drive.run().result();
  robot_.checkStop();
  if (result.verdict != Verdict::kGood) explain(drive.run(), drive.whyLost(), &result);
  const std::string status = save(drive.run().problem(), result, samples_.set().camera_frame);
  if (result.verdict != Verdict::kRefused) samples_.close();
  return status + back + samples_.keptText();
}

void CalibratorRos::show(const CalibrationRun& run, const std::vector<Eigen::Isometry3d>& way) {
  const auto& solution = run.solution();
  auto markers = makePlanMarkers(params_.base_frame, params_.mountingValue(), run.poses(),
                                 solution ? &*solution : nullptr);
  addWay(params_.base_frame, way, &markers);
  markers_.publish(markers);
  const std::string next = describeWay(way);
  const std::lock_guard<std::mutex> lock(status_mutex_);
  poses_so_far_ = summarize(run.poses()) + (next.empty() ? "" : "; the next way leads " + next);
}

bool CalibratorRos::next(Request&, Response& response) {
  response.success = robot_.go();
  response.message = response.success ? "the robot goes" : "no move waits for ~next";
  return true;
}

std::string CalibratorRos::save(const HandEyeProblem& problem, const HandEyeResult& result,
                                const std::string& camera_frame) {
  planar_bin_picking::CalibrationNames names;
  names.camera_name = params_.camera_name;
  names.mount_frame =
      problem.mounting == Mounting::kEyeInHand ? params_.flange_frame : params_.base_frame;
  names.camera_frame = params_.camera_frame.empty() ? camera_frame : params_.camera_frame;
  planar_bin_picking::SaveOptions save;
  save.pictures = std::filesystem::absolute(params_.output_folder).string() + "/";
  const std::string folder =
      planar_bin_picking::saveCalibration(params_.output_folder, problem, result, names, save);
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
  for (const std::string& note : result.notes) status << " " << note << ";";
  status << " see " << std::filesystem::absolute(folder).lexically_normal().string()
         << "/report.html";
  return status.str();
}

void CalibratorRos::showPlan(const Look& first) {
  CalibrationRun run(board_.problemFor(first), params_.solver, params_.run, first.T_base_flange);
  std::vector<Eigen::Isometry3d> way{first.T_base_flange};
  // Later poses depend on what is seen: these are the first ones.
  constexpr int kFirstPoses = 6;
  for (int i = 0; i < kFirstPoses && run.next(); ++i) {
    if (way.size() == 1) way.insert(way.end(), run.way().begin(), run.way().end());
    while (const auto pose = run.step()) run.arrived(*pose);
  }
  show(run, way);
}

bool CalibratorRos::plan(Request&, Response& response) {
  const auto say = [&](const std::string& begin, const std::string& end) {
    const std::lock_guard<std::mutex> lock(status_mutex_);
    response.success = true;
    response.message = begin + poses_so_far_ + end;
  };
  if (task_.duringRun([&] { say("under way; on ~plan_markers are ", ""); })) return true;
  return answer(&response, [&] {
    const auto hold = begin(CalibratorTask::Kind::kPlan);
    showPlan(board_.take());
    say("on ~plan_markers are the first ", "; later ones follow from what is seen");
  });
}

bool CalibratorRos::addSample(Request&, Response& response) {
  return answer(&response, [&] {
    const auto hold = begin(CalibratorTask::Kind::kAddSample);
    planar_bin_picking::checkCalibrationFolder(params_.output_folder);
    const Look seen = board_.take();
    response.success = seen.board.status == BoardObservation::Status::kFound;
    if (response.success) samples_.add(seen, board_.problemFor(seen));
    response.message =
        (response.success ? "taken" : whyNoBoard(seen.board, seen.image, board_.board())) +
        std::string("; there are ") + std::to_string(samples_.size()) + " samples; ~finish solves";
  });
}

bool CalibratorRos::removeSample(planar_bin_picking::RemoveSample::Request& request,
                                 planar_bin_picking::RemoveSample::Response& response) {
  return answer(&response, [&] {
    const auto hold = begin(CalibratorTask::Kind::kSamples);
    samples_.remove(request.number);
    response.success = true;
    response.message = "left are " + samples_.list();
  });
}

bool CalibratorRos::listSamples(Request&, Response& response) {
  return answer(&response, [&] {
    const auto hold = begin(CalibratorTask::Kind::kSamples);
    response.success = true;
    response.message = samples_.list();
  });
}

bool CalibratorRos::loadSamples(Request&, Response& response) {
  return answer(&response, [&] {
    const auto hold = begin(CalibratorTask::Kind::kSamples);
    if (!samples_.isEmpty()) {
      throw std::runtime_error("there are samples already" + samples_.keptText() +
                               ", ~remove_sample removes them");
    }
    samples_.load();
    response.success = true;
    response.message = "loaded " + samples_.list();
  });
}

bool CalibratorRos::finish(Request&, Response& response) {
  return answer(&response, [&] {
    const auto hold = begin(CalibratorTask::Kind::kFinish);
    if (samples_.isEmpty()) {
      throw std::runtime_error(
          "there are no samples; take some with ~add_sample, or go on with "
          "those in output_folder by ~load_samples");
    }
    HandEyeProblem problem = samples_.set().problem;
    // The lens that stays as it is is not among the samples on disk.
    if (params_.fixed_camera) problem.camera = board_.problemFor(board_.take()).camera;
    const HandEyeResult result = planar_bin_picking::solveHandEye(problem, params_.solver);
    response.message = save(problem, result, samples_.set().camera_frame);
    response.success = result.verdict != Verdict::kRefused;
    if (response.success) samples_.close();
    setStatus(response.message);
  });
}

bool CalibratorRos::verify(Request&, Response& response) {
  return answer(&response, [&] {
    const auto hold = begin(CalibratorTask::Kind::kVerify);
    const Look seen = board_.takeWithBoard();
    const auto check = verifier_.verify(seen, board_.problemFor(seen));
    response.success = check.holds();
    response.message = check.text;
  });
}

}  // namespace planar_bin_picking_ros
