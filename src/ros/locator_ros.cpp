// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator_ros.h"

#include "bin_range.h"
#include "convert.h"
#include "load_params.h"
#include "names.h"
#include "plane_frame.h"
#include "refusal.h"
#include "timed_call.h"
#include "transforms.h"

#include <ros/console.h>
#include <std_srvs/Trigger.h>

#include <chrono>
#include <cstdio>
#include <sstream>

namespace planar_bin_picking_ros {

using planar_bin_picking::Camera;
using planar_bin_picking::FaceFilter;
using planar_bin_picking::LocateRequest;

namespace {

constexpr std::size_t kCalls = 4;  ///< served at once; further ones queue up

ros::NodeHandle onQueue(ros::NodeHandle nh, ros::CallbackQueue* queue) {
  nh.setCallbackQueue(queue);
  return nh;
}

FaceFilter faceFilter(const std::uint8_t face) {
  using Request = planar_bin_picking::LocatePart::Request;
  switch (face) {
    case Request::ANY:
      return FaceFilter::kAny;
    case Request::FRONT:
      return FaceFilter::kFront;
    case Request::BACK:
      return FaceFilter::kBack;
  }
  throw Refusal(planar_bin_picking::LocatePart::Response::BAD_REQUEST,
                "face is " + std::to_string(face) + "; it must be ANY (0), FRONT (1) or BACK (2)");
}

std::optional<Camera> loadCameraFile(const std::string& path) {
  if (path.empty()) return std::nullopt;
  return planar_bin_picking::loadCamera(path);
}

/// How many poses the plane ruled out.
std::size_t offPlane(const planar_bin_picking::Report& report) {
  const auto& stages = report.stages;
  for (std::size_t i = 1; i < stages.size(); ++i)
    if (stages[i].name == "plane") return stages[i - 1].out - stages[i].out;
  return 0;
}

std::string nothingFound(const double threshold, const LocateRequest& request,
                         const planar_bin_picking::Report& report) {
  char text[300];
  std::snprintf(text, sizeof text,
                "nothing scored %.2f or more between %.3f and %.3f m from the camera; if there are "
                "parts, look at ~overlay, check light, focus and these distances",
                threshold, request.distance_min, request.distance_max);
  const std::size_t off = offPlane(report);
  if (off == 0) return text;
  return text +
         ("; " + std::to_string(off) + " poses lay off the plane: check where it is said to " +
          "be, and the parts' thickness_mm");
}

}  // namespace

/// Fills in the answer's times, step by step.
class LocatorRos::Stopwatch {
 public:
  explicit Stopwatch(Response& response) : response_(response) {}
  void lap(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    add(stage, std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }
  void lap(const std::vector<planar_bin_picking::Report::Stage>& stages) {
    for (const auto& stage : stages) add(stage.name, stage.seconds);
    last_ = std::chrono::steady_clock::now();
  }

 private:
  void add(const std::string& stage, const double seconds) {
    response_.times.emplace_back();
    response_.times.back().stage = stage;
    response_.times.back().seconds = seconds;
  }

  Response& response_;
  SteadyTime last_ = std::chrono::steady_clock::now();
};

LocatorRos::LocatorRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh)
    : locator_(loadLocatorParams(readTree(pnh, kLocatorParams))),
      cell_(loadCellParams(readTree(pnh, kCellParams))),
      camera_(loadCameraFile(cell_.camera_info_file)),
      library_(cell_.parts_folder),
      image_nh_(onQueue(nh, &image_queue_)),
      call_pnh_(onQueue(pnh, &call_queue_)),
      tf_listener_(tf_buffer_),
      source_(image_nh_, pnh),
      publisher_(call_pnh_, cell_.frame_prefix),
      picks_(loadPickParams(readTree(pnh, kPickParams))),
      image_spinner_(1, &image_queue_),
      call_spinner_(kCalls, &call_queue_) {
  checkOnePlane(cell_, locator_.params().plane);
  ROS_INFO_STREAM("locator:" << describe(locator_.params()));
  ROS_INFO_STREAM("cell:" << describe(cell_));
  for (const auto& part : library_.parts()) ROS_INFO_STREAM("part '" << part.first << "' loaded");
  for (const auto& [name, error] : library_.errors()) {
    ROS_ERROR_STREAM("part '" << name << "' is not available: " << error);
  }
  service_ = call_pnh_.advertiseService(kLocatePartService, &LocatorRos::serve, this);
  report_service_ = call_pnh_.advertiseService(kReportPickService, &LocatorRos::serveReport, this);
  image_spinner_.start();
  call_spinner_.start();
  ROS_INFO_STREAM("ready: images from " << source_.topic() << ", calls on "
                                        << service_.getService());
}

LocatorRos::~LocatorRos() {
  source_.close();  // before the spinner, which waits for the calls that are being served
  service_.shutdown();
  report_service_.shutdown();
  call_spinner_.stop();
  image_spinner_.stop();
}

bool LocatorRos::serve(Request& request, Response& response) {
  try {
    answer(request, response);
    ROS_INFO_STREAM("locate_part '" << request.part << "': " << response.message);
  } catch (const Refusal& refusal) {
    response.status = refusal.status();
    response.message = refusal.what();
    ROS_WARN_STREAM("locate_part '" << request.part << "': " << response.message);
  } catch (const std::exception& error) {
    response.status = Response::INTERNAL_ERROR;
    response.message = std::string(error.what()) + "; please report this with the image";
    ROS_ERROR_STREAM("locate_part '" << request.part << "': " << response.message);
  }
  return true;  // the call itself worked, whatever its status
}

bool LocatorRos::serveReport(planar_bin_picking::ReportPick::Request& request,
                             planar_bin_picking::ReportPick::Response& response) {
  picks_.report(request, &response);
  ROS_INFO_STREAM("report_pick '" << request.child_frame << "': " << response.message);
  return true;
}

Camera LocatorRos::cameraOf(const Frame& frame) const {
  if (!camera_) return toCamera(*frame.info, *frame.image);
  const Camera::Model& model = camera_->model();
  const int width = static_cast<int>(frame.image->width);
  const int height = static_cast<int>(frame.image->height);
  if (model.width == width && model.height == height) return *camera_;
  std::ostringstream text;
  text << "camera_info: " << cell_.camera_info_file << " is for " << model.width << " x "
       << model.height << " pixels, the image has " << width << " x " << height
       << "; calibrate at this resolution";
  throw Refusal(planar_bin_picking::LocatePart::Response::BAD_CAMERA_INFO, text.str());
}

void LocatorRos::answer(const Request& request, Response& response) {
  Stopwatch watch(response);
  const std::vector<PartPtr> parts = library_.select(request.part);
  faceFilter(request.face);  // refuses a wrong request before it waits
  const Frame frame = awaitFrame(request);
  watch.lap("wait");

  const std_msgs::Header& image = frame.image->header;
  Answer answer{parts, frame, toGrey(frame.image), cameraOf(frame), {}, image, {}};
  watch.lap("convert");

  answer.header.frame_id = cell_.target_frame.empty() ? image.frame_id : cell_.target_frame;
  const auto T_target_camera = transform(answer.header.frame_id, image.frame_id, image.stamp);
  const LocateRequest locate_request = makeRequest(request, answer);
  watch.lap("transform");
  {
    // One at a time: a call uses all cores anyway, and two would need twice the memory.
    const std::lock_guard<std::mutex> lock(locate_mutex_);
    watch.lap("queue");
    answer.result = locator_.locate(answer.grey, answer.camera, locate_request);
  }
  const planar_bin_picking::Report report = answer.result.report;
  watch.lap(report.stages);

  for (const auto& detection : answer.result.detections) {
    answer.located.push_back(toMsg(detection, *parts.at(detection.part), T_target_camera));
    answer.located.back().header = answer.header;
  }
  const auto sorted = picks_.sort(&answer, pickFrames(answer.header, T_target_camera));
  response.refused = sorted.refused;
  const std::size_t count = answer.located.size();
  response.parts = publisher_.publish(std::move(answer))->located;
  picks_.keep(response.parts, sorted.offered);
  watch.lap("publish");
  if (count > 0) {
    response.status = Response::OK;
    response.message = std::to_string(count) + " located";
  } else if (!response.refused.empty()) {
    response.status = Response::DEADLOCK;
    response.message = "none of " + std::to_string(response.refused.size()) +
                       " located parts can be offered: " + sorted.hint;
  } else {
    response.status = Response::NO_PART_FOUND;
    response.message = nothingFound(locator_.params().score.threshold, locate_request, report);
  }
}

Frame LocatorRos::awaitFrame(const Request& request) {
  if (request.timeout < ros::Duration(0)) {
    throw Refusal(Response::BAD_REQUEST,
                  "timeout is negative; zero means the cell's image_timeout");
  }
  const bool triggers = !cell_.trigger_service.empty();
  const ros::Time not_before =
      request.not_before.isZero() && triggers ? ros::Time::now() : request.not_before;
  if (triggers) trigger();
  return source_.await(
      not_before, request.timeout.isZero() ? ros::Duration(cell_.image_timeout) : request.timeout);
}

void LocatorRos::trigger() {
  std_srvs::Trigger service;
  const std::string name = image_nh_.resolveName(cell_.trigger_service);
  switch (callWithin(image_nh_, name, cell_.trigger_timeout, &service)) {
    case CallEnd::kAnswered:
      // An image may come all the same: the HDR node passes a single exposure on.
      if (!service.response.success) ROS_WARN_STREAM(name << ": " << service.response.message);
      return;
    case CallEnd::kLate:
      throw Refusal(Response::NO_IMAGE,
                    name +
                        " did not answer within ~cell/trigger_timeout; look at the node that "
                        "takes the images, or allow it more time");
    case CallEnd::kNobody:
    case CallEnd::kFailed:
      break;
  }
  throw Refusal(Response::NO_IMAGE, "nobody answers " + name +
                                        "; start what takes the images, or correct "
                                        "~cell/trigger_service");
}

PickKeeper::Frames LocatorRos::pickFrames(const std_msgs::Header& answer,
                                          const Eigen::Isometry3d& T_target_camera) const {
  PickKeeper::Frames frames{T_target_camera, std::nullopt};
  if (!cell_.hasBin()) return frames;
  frames.bin.emplace();
  frames.bin->T_bin_target = transform(cell_.bin_frame, answer.frame_id, answer.stamp);
  frames.bin->min = Eigen::Vector3d(cell_.bin_min[0], cell_.bin_min[1], cell_.bin_min[2]);
  frames.bin->max = Eigen::Vector3d(cell_.bin_max[0], cell_.bin_max[1], cell_.bin_max[2]);
  return frames;
}

Eigen::Isometry3d LocatorRos::transform(const std::string& target, const std::string& source,
                                        const ros::Time& stamp) const {
  if (target == source) return Eigen::Isometry3d::Identity();
  const LookupResult found =
      lookup(tf_buffer_, target, source, stamp, std::chrono::duration<double>(cell_.tf_timeout));
  if (!found.T_target_source) {
    throw Refusal(Response::NO_TRANSFORM,
                  "no transform from " + source + " to " + target +
                      " at the image's stamp: " + found.reason +
                      "; check that the robot publishes tf and the hand-eye calibration");
  }
  return *found.T_target_source;
}

LocateRequest LocatorRos::makeRequest(const Request& request, const Answer& answer) const {
  const std_msgs::Header& image = answer.frame.image->header;
  DistanceRange range{cell_.distance_min, cell_.distance_max};
  if (cell_.hasBin()) {
    range = distanceRange(cell_, transform(image.frame_id, cell_.bin_frame, image.stamp));
  }
  LocateRequest locate_request;
  locate_request.parts = answer.parts;
  locate_request.distance_min = range.min;
  locate_request.distance_max = range.max;
  locate_request.face = faceFilter(request.face);
  locate_request.max_parts = request.max_parts;
  if (!cell_.plane_frame.empty()) {
    locate_request.plane =
        planeOfFrame(cell_.plane_frame, transform(image.frame_id, cell_.plane_frame, image.stamp));
  }
  checkPlane(locate_request, answer.camera, locator_.params().plane);
  return locate_request;
}

}  // namespace planar_bin_picking_ros
