// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/locator_ros.h"

#include "locator/bin_range.h"
#include "locator/call_checks.h"
#include "locator/conclusion.h"
#include "locator/plane_frame.h"
#include "locator/settings/load_params.h"
#include "planar_bin_picking/image/camera_file.h"
#include "planar_bin_picking/locate/locator.h"
#include "shared/convert_camera.h"
#include "shared/names.h"
#include "shared/param_reader.h"
#include "shared/refusal.h"
#include "shared/timed_call.h"

#include <ros/console.h>
#include <std_srvs/Trigger.h>

#include <chrono>
#include <cstdio>
#include <sstream>

namespace planar_bin_picking_ros {

using planar_bin_picking::Camera;
using planar_bin_picking::LocatePart;
using planar_bin_picking::LocateRequest;

namespace {

/// Served at once; further ones queue up. Most of them wait for an image, which costs a thread.
constexpr std::size_t kCalls = 32;

ros::NodeHandle onQueue(ros::NodeHandle nh, ros::CallbackQueue* queue) {
  nh.setCallbackQueue(queue);
  return nh;
}

/// The parts' names as the request has them.
std::string wishOf(const LocatePart::Request& request) {
  std::string text = request.part;
  for (const std::string& part : request.parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

std::optional<Camera> loadCameraFile(const std::string& path) {
  if (path.empty()) return std::nullopt;
  return planar_bin_picking::loadCamera(path);
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
    : start_(loadSettings(pnh)),
      cell_(start_.cell),
      camera_(loadCameraFile(cell_.camera_info_file)),
      parts_(cell_.parts_folder, cell_.parts_poll),
      image_nh_(onQueue(nh, &image_queue_)),
      call_pnh_(onQueue(pnh, &call_queue_)),
      prompt_pnh_(onQueue(pnh, &prompt_queue_)),
      tf_buffer_(cell_.tf_gap_max),
      tf_listener_(tf_buffer_),
      cell_frames_(tf_buffer_, cell_.tf_timeout),
      source_(image_nh_, pnh),
      publisher_(call_pnh_, prompt_pnh_, cell_.frame_prefix),
      scene_(call_pnh_),
      tuning_(start_, prompt_pnh_),
      region_(regionSettings(), tf_buffer_, onQueue(nh, &prompt_queue_), prompt_pnh_, scene_),
      picks_(start_.pick),
      part_services_(parts_, call_pnh_, prompt_pnh_),
      snapshots_(cell_, call_pnh_),
      health_(
          source_, parts_, tuning_, [this](const auto& frame) { cameraOf(frame); }, prompt_pnh_),
      bin_(binHost(), call_pnh_),
      views_(image_nh_, call_pnh_, pnh, start_.locator, cell_, viewHost()),
      image_spinner_(1, &image_queue_),
      call_spinner_(kCalls, &call_queue_),
      prompt_spinner_(1, &prompt_queue_) {
  checkOnePlane(cell_, start_.locator.plane);
  showCell(cell_);
  ROS_INFO_STREAM(describe(start_));
  service_ = call_pnh_.advertiseService(kLocatePartService, &LocatorRos::serve, this);
  report_service_ =
      prompt_pnh_.advertiseService(kReportPickService, &LocatorRos::serveReport, this);
  image_spinner_.start();
  call_spinner_.start();
  prompt_spinner_.start();
  ROS_INFO_STREAM("ready: images from " << source_.topic() << ", calls on "
                                        << service_.getService());
}

LocatorRos::~LocatorRos() {
  source_.close();  // before the spinner, which waits for the calls that are being served
  views_.close();
  bin_.close();
  service_.shutdown();
  report_service_.shutdown();
  call_spinner_.stop();
  prompt_spinner_.stop();
  image_spinner_.stop();
}

bool LocatorRos::serve(Event<LocatePart>& event) {
  const Request& request = event.getRequest();
  Response& response = event.getResponse();
  Health::Call call(health_);
  response.filling = -1.0;
  try {
    answer(event.getCallerName(), request, response);
    ROS_INFO_STREAM(kLocatePartService << " '" << wishOf(request) << "': " << response.message);
  } catch (const Refusal& refusal) {
    response.status = refusal.status();
    response.message = refusal.what();
    ROS_WARN_STREAM(kLocatePartService << " '" << wishOf(request) << "': " << response.message);
  } catch (const std::exception& error) {
    response.status = Response::INTERNAL_ERROR;
    response.message = std::string(error.what()) + "; please report this with the image";
    ROS_ERROR_STREAM(kLocatePartService << " '" << wishOf(request) << "': " << response.message);
  }
  const bool has_answer = response.status == Response::OK || response.status == Response::EMPTY ||
                          response.status == Response::NO_PART_FOUND ||
                          response.status == Response::DEADLOCK;
  if (!has_answer) publisher_.clearMarkers();
  call.answered(response);
  return true;  // the call itself worked, whatever its status
}

bool LocatorRos::serveReport(Event<planar_bin_picking::ReportPick>& event) {
  picks_.report(event.getCallerName(), event.getRequest(), &event.getResponse());
  if (event.getResponse().status != planar_bin_picking::ReportPick::Response::UNKNOWN_PART)
    snapshots_.reported(event.getRequest().success);
  ROS_INFO_STREAM("report_pick '" << event.getRequest().child_frame
                                  << "': " << event.getResponse().message);
  return true;
}

Camera LocatorRos::cameraOf(const Frame& frame) const {
  checkSize(*frame.image);
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

void LocatorRos::answer(const std::string& caller, const Request& request, Response& response) {
  Stopwatch watch(response);
  const auto settings = tuning_.current();
  const ros::Time asked = request.not_before.isZero() ? ros::Time::now() : request.not_before;
  const auto library = parts_.current();
  const std::vector<PartPtr> parts = library->select(request.part, request.parts);
  publisher_.withdraw(parts);  // whatever comes of this call, the former answer no longer holds
  faceFilter(request.face);    // refuses a wrong request before it waits
  checkTimes(request);
  checkFlange(request.flange);
  const Frame frame = awaitFrame(request);
  watch.lap("wait");

  const std_msgs::Header& image = frame.image->header;
  Answer answer{parts, frame, toGrey(frame.image), cameraOf(frame), {}, image, {}, {}};
  watch.lap("convert");

  answer.header.frame_id = cell_.target_frame.empty() ? image.frame_id : cell_.target_frame;
  const Standing standing =
      cell_frames_.at(settings->cell, image, answer.header.frame_id, request.flange);
  const Eigen::Isometry3d& T_target_camera = standing.pick.T_target_camera;
  LocateRequest locate_request = cell_frames_.request(settings->cell, standing);
  locate_request.parts = answer.parts;
  locate_request.face = faceFilter(request.face);
  const std::string unsuitable = dropUnsuitable(answer.camera, &locate_request);
  checkPlane(locate_request, answer.camera, settings->locator.plane);
  answer.parts = locate_request.parts;
  const SeenRegion region{region_.current(), standing.T_region_camera};
  locate_request.window = windowOf(region, answer.camera, locate_request);
  watch.lap("transform");
  locate(settings->locator, locate_request, &watch, &answer);
  // What one camera's picture says: this alone can be replayed.
  CallRecord record{answer, locate_request, *settings, library, T_target_camera, request, {}};
  if (views_.lookInSecond(asked, request.timeout, T_target_camera, &answer))
    watch.lap("second camera");
  planar_bin_picking::FloorCover cover;
  if (standing.T_camera_bin) {
    cover = lookIntoBin(settings->cell, *standing.T_camera_bin, answer);
    watch.lap("floor");
  }
  keepWithin(region, &answer);
  show(settings->cell, standing, region, locate_request.distance_max, &answer);
  const Answer seen = answer;
  auto offered =
      offer(std::move(answer), standing.pick, {caller, request.max_parts, settings->pick});
  views_.keep(seen, offered, standing.pick);
  watch.lap("publish");
  response.parts = std::move(offered.parts);
  response.refused = std::move(offered.refused);
  conclude({locate_request, seen.result.report, settings->locator.score.threshold, offered.hint,
            settings->cell, cover},
           &response);
  if (!unsuitable.empty()) response.message += "; not looked for: " + unsuitable;
  record.answered = response;
  snapshots_.note(std::move(record));
}

void LocatorRos::locate(const planar_bin_picking::LocatorParams& params,
                        const LocateRequest& request, Stopwatch* watch, Answer* answer) {
  const std::lock_guard<std::mutex> lock(locate_mutex_);
  watch->lap("queue");
  answer->result =
      planar_bin_picking::Locator(params).locate(answer->grey, answer->camera, request);
  watch->lap(answer->result.report.stages);
}

PickKeeper::Offered LocatorRos::offer(Answer answer, const PickKeeper::Frames& frames,
                                      const PickKeeper::Call& call) {
  return picks_.offer(std::move(answer), frames, call, [this](Answer sorted) {
    return publisher_.publish(std::move(sorted))->located;
  });
}

void LocatorRos::showCell(const CellParams& cell) {
  if (cell.hasBin()) {
    scene_.show("bin",
                binMarkers(cell.bin_frame, foundBin(cell), Eigen::Vector3d(cell.bin_min.data()),
                           Eigen::Vector3d(cell.bin_max.data())));
  }
  if (!cell.plane_frame.empty()) scene_.show("plane", planeMarkers(cell.plane_frame));
}

void LocatorRos::show(const CellParams& cell, const Standing& standing, const SeenRegion& region,
                      const double distance, Answer* answer) {
  addOutlines(cell, standing.T_camera_bin, region, answer);
  showCell(cell);
  scene_.show("next view", {});  // was of the answer before
  scene_.show("camera",
              cameraMarkers({"camera", answer->header.frame_id, standing.pick.T_target_camera,
                             answer->camera, distance, region.region.pixels}));
}

Frame LocatorRos::awaitImage(const ros::Time& not_before, const ros::Duration& timeout) {
  Request request;
  request.not_before = not_before;
  request.timeout = timeout;
  return awaitFrame(request);
}

RegionKeeper::Settings LocatorRos::regionSettings() const {
  RegionKeeper::Settings settings{cell_.region,
                                  cell_.region_px,
                                  cell_.regionFrame(),
                                  cell_.region_file,
                                  cell_.tf_timeout,
                                  {},
                                  {}};
  const bool is_of_bin = cell_.hasBin() && cell_.regionFrame() == cell_.bin_frame;
  if (is_of_bin) settings.floor = floorOf(cell_);
  settings.T_frame_region = [this, is_of_bin] {
    return is_of_bin ? foundBin(tuning_.current()->cell) : Eigen::Isometry3d::Identity();
  };
  return settings;
}

PictureHost LocatorRos::pictureHost() {
  return {[this](const auto&... args) { return awaitImage(args...); },
          [this](const auto& frame) { return cameraOf(frame); },
          [this](const auto&... args) { return cell_frames_.transform(args...); }, &locate_mutex_};
}

BinFinder::Host LocatorRos::binHost() {
  const auto use = [this](const Eigen::Isometry3d& T_told_found) {
    tuning_.useBin(foundBin(T_told_found));
    showCell(tuning_.current()->cell);
    region_.redraw();
  };
  return {pictureHost(), [this] { return binSettings(tuning_.current()->cell); }, use,
          [this] { return planar_bin_picking::Locator(tuning_.current()->locator); }};
}

ViewServices::Host LocatorRos::viewHost() {
  const auto stands = [this](const auto& image, const auto& flange) {
    return cell_frames_.at(tuning_.current()->cell, image, cell_.target_frame, flange);
  };
  const auto offer_all = [this](Answer answer, const Standing& standing, const auto& caller) {
    const auto settings = tuning_.current();
    SeenRegion region{region_.current(), standing.T_region_camera};
    region.region.pixels.clear();  // of the first picture; this one may be taken from elsewhere
    keepWithin(region, &answer);
    return offer(std::move(answer), standing.pick, {caller, 0, settings->pick});
  };
  const auto show = [this](const auto& T_target_camera, const Camera& camera) {
    scene_.show("next view", cameraMarkers({"next_view",
                                            cell_.target_frame,
                                            T_target_camera,
                                            camera,
                                            cell_.focus_min,
                                            {},
                                            "next view"}));
  };
  return {pictureHost(), offer_all, stands, show};
}

Frame LocatorRos::awaitFrame(const Request& request) {
  const ros::Duration timeout =
      request.timeout.isZero() ? ros::Duration(cell_.image_timeout) : request.timeout;
  if (cell_.trigger_service.empty()) return source_.await(request.not_before, timeout);
  // Taken before the trigger is sent: its image may be here before its answer is.
  const SteadyTime sent = std::chrono::steady_clock::now();
  const ros::Time not_before = request.not_before.isZero() ? ros::Time::now() : request.not_before;
  trigger();
  return source_.await(not_before, timeout, sent);
}

void LocatorRos::trigger() {
  std_srvs::Trigger service;
  const std::string name = image_nh_.resolveName(cell_.trigger_service);
  std::string why =
      " is not answered by anybody; start what takes the images, or correct "
      "~cell/trigger_service";
  switch (callWithin(image_nh_, name, cell_.trigger_timeout, &service)) {
    case CallEnd::kAnswered:
      if (service.response.success) return;
      why = " made no image: " + service.response.message;
      break;
    case CallEnd::kLate:
      why =
          " did not answer within ~cell/trigger_timeout; look at the node that takes the images, "
          "or allow it more time";
      break;
    case CallEnd::kNobody:
    case CallEnd::kFailed:
      break;
  }
  throw Refusal(Response::NO_IMAGE, "the trigger " + name + why);
}

}  // namespace planar_bin_picking_ros
