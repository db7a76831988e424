// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/locator_ros.h"

#include "locator/bin_range.h"
#include "locator/conclusion.h"
#include "locator/plane_frame.h"
#include "locator/settings/load_params.h"
#include "planar_bin_picking/image/camera_file.h"
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
using planar_bin_picking::FaceFilter;
using planar_bin_picking::LocatePart;
using planar_bin_picking::LocateRequest;

namespace {

/// Served at once; further ones queue up. Most of them wait for an image, which costs a thread.
constexpr std::size_t kCalls = 32;
constexpr double kLongestWait = 3600.0;  ///< s; a call that waits longer has been forgotten
constexpr int kLeastPixels = 64;         ///< per side, as Locator::locate has it

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

/// @throws Refusal  BAD_REQUEST: a time that no image can meet
void checkTimes(const LocatePart::Request& request) {
  const auto refuse = [](const std::string& text) {
    throw Refusal(LocatePart::Response::BAD_REQUEST, text);
  };
  if (request.timeout < ros::Duration(0))
    refuse("timeout is negative; zero means the cell's image_timeout");
  if (request.timeout.toSec() > kLongestWait)
    refuse("timeout is " + std::to_string(request.timeout.toSec()) + " s; an hour is the most");
  const ros::Time now = ros::Time::now();
  if (!now.isZero() && request.not_before.toSec() - now.toSec() > kLongestWait) {
    refuse("not_before lies " + std::to_string(request.not_before.toSec() - now.toSec()) +
           " s in the future; give the time at which the robot stood still, or zero for now");
  }
}

void checkSize(const sensor_msgs::Image& image) {
  if (image.width >= kLeastPixels && image.height >= kLeastPixels) return;
  throw Refusal(LocatePart::Response::BAD_IMAGE,
                "image: is " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                    " pixels, must have " + std::to_string(kLeastPixels) +
                    " each way; check the driver's region of interest");
}

/// Takes out parts that cannot be located in such a picture.
/// @return  what is wrong with them; "" where nothing is
/// @throws Refusal  BAD_PART_SIZE: none is left
std::string dropUnsuitable(const Camera& camera, LocateRequest* request) {
  std::string text;
  std::vector<PartPtr> suitable;
  for (const PartPtr& part : request->parts) {
    try {
      planar_bin_picking::checkPartSize(*part, camera, request->distance_min,
                                        request->distance_max);
      suitable.push_back(part);
    } catch (const planar_bin_picking::PartSizeError& error) {
      text += (text.empty() ? "" : "; ") + std::string(error.what());
    }
  }
  if (suitable.empty()) throw Refusal(LocatePart::Response::BAD_PART_SIZE, text);
  request->parts = suitable;
  return text;
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
      parts_(cell_.parts_folder, cell_.parts_poll),
      image_nh_(onQueue(nh, &image_queue_)),
      call_pnh_(onQueue(pnh, &call_queue_)),
      prompt_pnh_(onQueue(pnh, &prompt_queue_)),
      tf_buffer_(cell_.tf_gap_max),
      tf_listener_(tf_buffer_),
      cell_frames_(cell_, tf_buffer_),
      source_(image_nh_, pnh),
      publisher_(call_pnh_, prompt_pnh_, cell_.frame_prefix),
      picks_(loadPickParams(readTree(pnh, kPickParams))),
      part_services_(parts_, call_pnh_, prompt_pnh_),
      snapshots_(
          {cell_.snapshot_folder, cell_.snapshots_max, cell_.snapshots_mb, cell_.snapshot_failures},
          settings(), call_pnh_),
      health_(source_, parts_, {!cell_.trigger_service.empty(), settings()}, prompt_pnh_),
      views_(image_nh_, call_pnh_, pnh, locator_.params(), cell_, viewHost()),
      image_spinner_(1, &image_queue_),
      call_spinner_(kCalls, &call_queue_),
      prompt_spinner_(1, &prompt_queue_) {
  checkOnePlane(cell_, locator_.params().plane);
  ROS_INFO_STREAM("locator:" << describe(locator_.params()));
  ROS_INFO_STREAM("cell:" << describe(cell_));
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
  service_.shutdown();
  report_service_.shutdown();
  call_spinner_.stop();
  prompt_spinner_.stop();
  image_spinner_.stop();
}

std::string LocatorRos::settings() const {
  return "locator:" + describe(locator_.params()) + "\ncell:" + describe(cell_) +
         "\npick:" + describe(picks_.params()) + "\n";
}

bool LocatorRos::serve(Event<LocatePart>& event) {
  const Request& request = event.getRequest();
  Response& response = event.getResponse();
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
  health_.called(response);
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
  const ros::Time asked = request.not_before.isZero() ? ros::Time::now() : request.not_before;
  const auto library = parts_.current();
  const std::vector<PartPtr> parts = library->select(request.part, request.parts);
  publisher_.withdraw(parts);  // whatever comes of this call, the former answer no longer holds
  faceFilter(request.face);    // refuses a wrong request before it waits
  checkTimes(request);
  const Frame frame = awaitFrame(request);
  watch.lap("wait");

  const std_msgs::Header& image = frame.image->header;
  Answer answer{parts, frame, toGrey(frame.image), cameraOf(frame), {}, image, {}, {}};
  watch.lap("convert");

  answer.header.frame_id = cell_.target_frame.empty() ? image.frame_id : cell_.target_frame;
  const auto T_target_camera =
      cell_frames_.transform(answer.header.frame_id, image.frame_id, image.stamp);
  LocateRequest locate_request = cell_frames_.request(image);
  locate_request.parts = answer.parts;
  locate_request.face = faceFilter(request.face);
  const std::string unsuitable = dropUnsuitable(answer.camera, &locate_request);
  checkPlane(locate_request, answer.camera, locator_.params().plane);
  answer.parts = locate_request.parts;
  const PickKeeper::Frames frames = cell_frames_.pickFrames(answer.header, T_target_camera);
  watch.lap("transform");
  {
    // One at a time: a call uses all cores anyway, and two would need twice the memory.
    const std::lock_guard<std::mutex> lock(locate_mutex_);
    watch.lap("queue");
    answer.result = locator_.locate(answer.grey, answer.camera, locate_request);
  }
  watch.lap(answer.result.report.stages);
  // What one camera's picture says: this alone can be replayed.
  CallRecord record{answer, locate_request, locator_.params(), library, T_target_camera, request,
                    {}};
  if (views_.lookInSecond(asked, request.timeout, T_target_camera, &answer))
    watch.lap("second camera");
  planar_bin_picking::FloorCover cover;
  if (frames.bin) {
    cover = lookIntoBin(cell_, (frames.bin->T_bin_target * T_target_camera).inverse(), answer);
    watch.lap("floor");
  }
  const Answer seen = answer;
  auto offered = offer(std::move(answer), frames, {caller, request.max_parts});
  views_.keep(seen, offered, frames);
  watch.lap("publish");
  response.parts = std::move(offered.parts);
  response.refused = std::move(offered.refused);
  conclude({locate_request, seen.result.report, locator_.params().score.threshold, offered.hint,
            cell_, cover},
           &response);
  if (!unsuitable.empty()) response.message += "; not looked for: " + unsuitable;
  record.answered = response;
  snapshots_.note(std::move(record));
}

PickKeeper::Offered LocatorRos::offer(Answer answer, const PickKeeper::Frames& frames,
                                      const PickKeeper::Call& call) {
  return picks_.offer(std::move(answer), frames, call, [this](Answer sorted) {
    return publisher_.publish(std::move(sorted))->located;
  });
}

ViewServices::Host LocatorRos::viewHost() {
  const auto await = [this](const ros::Time& not_before, const ros::Duration& timeout) {
    Request request;
    request.not_before = not_before;
    request.timeout = timeout;
    return awaitFrame(request);
  };
  const auto offer_all = [this](Answer answer, const auto& T_target_camera, const auto& caller) {
    const auto frames = cell_frames_.pickFrames(answer.header, T_target_camera);
    return offer(std::move(answer), frames, {caller, 0});
  };
  return {await, [this](const auto& frame) { return cameraOf(frame); },
          [this](const auto&... args) { return cell_frames_.transform(args...); }, offer_all,
          &locate_mutex_};
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
