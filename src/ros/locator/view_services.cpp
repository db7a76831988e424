// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/view_services.h"

#include "planar_bin_picking/views/hand_eye_error.h"
#include "planar_bin_picking/views/next_view.h"
#include "shared/convert.h"
#include "shared/convert_camera.h"
#include "shared/names.h"
#include "shared/refusal.h"

#include <ros/console.h>

#include <chrono>
#include <cstdio>
#include <map>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::Detection;
using planar_bin_picking::LookResult;
using planar_bin_picking::LookStatus;
using planar_bin_picking::PartLook;
using planar_bin_picking::View;
using planar_bin_picking::ViewPtr;

namespace {

constexpr double kLongestWait = 3600.0;  // s, as LocatePart's

planar_bin_picking::LocatorParams withHandEye(planar_bin_picking::LocatorParams params,
                                              const CellParams& cell) {
  if (cell.hand_eye_file.empty()) return params;
  const auto error = planar_bin_picking::loadHandEyeError(cell.hand_eye_file);
  params.views.hand_eye_sigma = error.metres;
  params.views.hand_eye_sigma_deg = error.degrees;
  return params;
}

/// Two cameras that stand still: the place of each is known as well as its calibration, by itself.
planar_bin_picking::LocatorParams ofFixedCameras(planar_bin_picking::LocatorParams params) {
  params.views.robot_sigma = params.views.hand_eye_sigma;
  params.views.robot_sigma_deg = params.views.hand_eye_sigma_deg;
  params.views.hand_eye_sigma = params.views.hand_eye_sigma_deg = 0.0;
  return params;
}

std::uint8_t lookOf(LookStatus status) {
  switch (status) {
    case LookStatus::kConfirmed:
      return PartLook::CONFIRMED;
    case LookStatus::kCorrected:
      return PartLook::CORRECTED;
    case LookStatus::kMoved:
      return PartLook::MOVED;
    case LookStatus::kContradicted:
      return PartLook::CONTRADICTED;
    case LookStatus::kNotSeen:
      break;
  }
  return PartLook::NOT_SEEN;
}

bool agrees(LookStatus status) {
  return status == LookStatus::kConfirmed || status == LookStatus::kCorrected;
}

void check(const planar_bin_picking::RefinePart::Request& request) {
  checkFlange(request.flange);
  const double timeout = request.timeout.toSec();
  if (timeout >= 0.0 && timeout <= kLongestWait) return;
  throw Refusal(planar_bin_picking::RefinePart::Response::BAD_REQUEST,
                "timeout is " + std::to_string(timeout) +
                    " s; give 0 for the cell's image_timeout, or up to an hour");
}

}  // namespace

/// What one call has seen.
struct ViewServices::Looks {
  std::vector<PartLook> looks;
  std::vector<KeptPart> agreed;       ///< with the new view
  std::vector<Detection> detections;  ///< the same in the new camera's frame
  std::vector<KeptPart> gone;         ///< those that are not where they were
};

ViewServices::ViewServices(const ros::NodeHandle& image_nh, const ros::NodeHandle& call_nh,
                           const ros::NodeHandle& pnh,
                           const planar_bin_picking::LocatorParams& params, const CellParams& cell,
                           Host host)
    : params_(withHandEye(params, cell)),
      cell_(cell),
      host_(std::move(host)),
      keeper_(params.edges) {
  if (!cell_.second_camera_topic.empty())
    second_ = std::make_unique<ImageSource>(image_nh, pnh, cell_.second_camera_topic);
  ros::NodeHandle nh(call_nh);
  refine_service_ = nh.advertiseService(kRefinePartService, &ViewServices::serveRefine, this);
  next_service_ = nh.advertiseService(kNextViewService, &ViewServices::serveNextView, this);
}

void ViewServices::close() {
  if (second_) second_->close();
  refine_service_.shutdown();
  next_service_.shutdown();
}

void ViewServices::keep(const Answer& answer, const PickKeeper::Offered& offered,
                        const PickKeeper::Frames& frames) {
  std::optional<planar_bin_picking::ViewBin> bin;
  if (frames.bin)
    bin.emplace(
        planar_bin_picking::ViewBin{frames.bin->T_bin_target, frames.bin->min, frames.bin->max});
  keeper_.keep(answer, offered.detections, offered.parts, offered.needs_view,
               frames.T_target_camera, bin);
}

bool ViewServices::serveRefine(Event<RefinePart>& event) {
  const RefinePart::Request& request = event.getRequest();
  RefinePart::Response& response = event.getResponse();
  try {
    refine(event.getCallerName(), request, &response);
  } catch (const Refusal& refusal) {
    response.status = refusal.status();
    response.message = refusal.what();
  } catch (const std::exception& error) {
    response.status = RefinePart::Response::INTERNAL_ERROR;
    response.message = std::string(error.what()) + "; please report this with the image";
    ROS_ERROR_STREAM("refine_part '" << request.child_frame << "': " << response.message);
  }
  ROS_INFO_STREAM("refine_part '" << request.child_frame << "': " << response.message);
  return true;  // the call itself worked, whatever its status
}

ViewServices::Looks ViewServices::lookAt(std::vector<KeptPart> parts, const Answer& now,
                                         const Eigen::Isometry3d& T_target_camera) const {
  const planar_bin_picking::Looker looker(params_);
  std::map<ViewPtr, ViewPtr> views;  // the new one, as seen from each first
  Looks out;
  for (KeptPart& kept : parts) {
    const ViewPtr first = kept.tracked.views.front();
    const Eigen::Isometry3d T_first_now = kept.T_target_first.inverse() * T_target_camera;
    ViewPtr& view = views[first];
    if (!view)
      view = std::make_shared<const View>(now.grey, now.camera, T_first_now, params_.edges);
    const LookResult result = looker.look(*kept.part, view, &kept.tracked);
    PartLook look;
    look.look = lookOf(result.status);
    look.child_frame = kept.child_frame;
    look.moved = result.moved;
    look.moved_angle = result.moved_rad;
    look.seen = result.seen;
    look.text = result.text;
    look.located = toMsg(result.detection, *kept.part, kept.T_target_first);
    look.located.header = now.header;
    out.looks.push_back(look);
    if (!agrees(result.status)) {
      if (result.status != LookStatus::kNotSeen) out.gone.push_back(std::move(kept));
      continue;
    }
    out.detections.push_back(result.detection);
    out.detections.back().T_camera_part = T_first_now.inverse() * result.detection.T_camera_part;
    out.agreed.push_back(std::move(kept));
  }
  return out;
}

void ViewServices::refine(const std::string& caller, const RefinePart::Request& request,
                          RefinePart::Response* response) {
  check(request);
  if (cell_.target_frame.empty()) {
    throw Refusal(RefinePart::Response::BAD_REQUEST,
                  "the cell names no target_frame, so that nobody knows where the camera was at "
                  "either picture: set ~cell/target_frame");
  }
  keeper_.find(request.stamp, request.child_frame, request.count);  // refuses before it waits
  auto last = std::chrono::steady_clock::now();
  const auto lap = [&](const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    response->times.emplace_back();
    response->times.back().stage = stage;
    response->times.back().seconds = std::chrono::duration<double>(now - last).count();
    last = now;
  };
  const Frame frame = host_.await(request.not_before, request.timeout);
  lap("wait");
  const std_msgs::Header& image = frame.image->header;
  Answer answer{{}, frame, toGrey(frame.image), host_.camera_of(frame), {}, image, {}, {}};
  answer.header.frame_id = cell_.target_frame;
  const Standing standing = host_.standing(image, request.flange);
  lap("convert");
  Looks seen;
  {
    const std::lock_guard<std::mutex> lock(*host_.locate_mutex);
    seen = lookAt(keeper_.find(request.stamp, request.child_frame, request.count), answer,
                  standing.pick.T_target_camera);
  }
  lap("look");
  response->looks = seen.looks;
  offerRefined(caller, std::move(answer), standing, std::move(seen), response);
  lap("publish");
  conclude(response);
}

void ViewServices::offerRefined(const std::string& caller, Answer answer, const Standing& standing,
                                Looks seen, RefinePart::Response* response) {
  answer.former.emplace();
  // One entry for each, so that it is known again after sorting; what has gone is only withdrawn.
  for (const auto* parts : {&seen.agreed, &seen.gone}) {
    for (const KeptPart& kept : *parts) {
      answer.parts.push_back(kept.part);
      answer.former->push_back({kept.stamp, kept.child_frame, parts == &seen.gone});
    }
  }
  if (answer.parts.empty()) return;
  for (std::size_t i = 0; i < seen.detections.size(); ++i) seen.detections[i].part = i;
  answer.result.detections = seen.detections;
  if (!seen.agreed.empty()) {
    const View& first = *seen.agreed.front().tracked.views.front();
    answer.first.emplace(
        FirstPicture{first.image(), first.camera(),
                     seen.agreed.front().T_target_first.inverse() * standing.pick.T_target_camera});
  }
  const std_msgs::Header header = answer.header;
  PickKeeper::Offered offered = host_.offer(std::move(answer), standing, caller);
  std::vector<KeptPart> kept;
  for (std::size_t i = 0; i < offered.parts.size(); ++i) {
    kept.push_back(seen.agreed[offered.detections[i].part]);
    kept.back().child_frame = offered.parts[i].child_frame;
    kept.back().stamp = header.stamp;
  }
  for (const Detection& detection : offered.needs_view) {
    kept.push_back(seen.agreed[detection.part]);
    kept.back().child_frame.clear();
    kept.back().stamp = header.stamp;
  }
  keeper_.keep(header, std::move(kept));
  response->parts = std::move(offered.parts);
  response->refused = std::move(offered.refused);
}

void ViewServices::conclude(RefinePart::Response* response) const {
  if (!response->parts.empty()) {
    response->status = RefinePart::Response::OK;
    response->message = std::to_string(response->parts.size()) + " of " +
                        std::to_string(response->looks.size()) + " offered; " +
                        response->looks.front().text;
    return;
  }
  response->status = RefinePart::Response::NOT_OFFERED;
  response->message = response->looks.front().text;
  for (const auto& refused : response->refused) response->message += "; refused: " + refused.text;
}

bool ViewServices::serveNextView(NextView::Request& request, NextView::Response& response) {
  try {
    propose(request, &response);
  } catch (const Refusal& refusal) {
    response.status = refusal.status();
    response.message = refusal.what();
  } catch (const std::exception& error) {
    response.status = NextView::Response::INTERNAL_ERROR;
    response.message = std::string(error.what()) + "; please report this";
  }
  return true;
}

Eigen::Isometry3d ViewServices::flangeFrom(const std::string& camera, const std::string& flange,
                                           const ros::Time& stamp) const {
  try {
    return host_.transform(camera, flange, stamp);
  } catch (const Refusal& refusal) {  // its numbers are those of LocatePart
    throw Refusal(NextView::Response::NO_TRANSFORM, "flange_frame: " + std::string(refusal.what()));
  }
}

void ViewServices::propose(const NextView::Request& request, NextView::Response* response) {
  if (cell_.next_view_min.empty() || cell_.target_frame.empty()) {
    throw Refusal(NextView::Response::NOT_SET,
                  "nobody says where the camera may go: set ~cell/target_frame, "
                  "~cell/next_view_min, ~cell/next_view_max, ~cell/focus_min and ~cell/focus_max");
  }
  const KeptPart kept = keeper_.find(request.stamp, request.child_frame, 1).front();
  planar_bin_picking::NextViewLimits limits;
  limits.box_min = Eigen::Vector3d(cell_.next_view_min.data());
  limits.box_max = Eigen::Vector3d(cell_.next_view_max.data());
  limits.cone_deg = cell_.next_view_cone_deg;
  limits.focus = {cell_.focus_min, cell_.focus_max};
  limits.bin = kept.bin;
  const Detection& known = kept.tracked.detection;
  const auto next = planar_bin_picking::nextView(known, *kept.part, kept.camera,
                                                 kept.T_target_first, limits, params_);
  if (!next) {
    throw Refusal(NextView::Response::NO_VIEW,
                  "no place of the camera within ~cell/next_view_min .. max, next_view_cone_deg "
                  "and focus_min .. max shows all of '" +
                      kept.part->name() + "': widen them");
  }
  const Eigen::Isometry3d T_target_camera = kept.T_target_first * next->T_first_camera;
  if (!request.flange_frame.empty()) {
    response->flange.header.frame_id = cell_.target_frame;
    response->flange.header.stamp = request.stamp;
    response->flange.pose = toPoseMsg(
        T_target_camera * flangeFrom(kept.camera_frame, request.flange_frame, request.stamp));
  }
  response->status = NextView::Response::OK;
  response->camera.header.stamp = request.stamp;
  response->camera.header.frame_id = cell_.target_frame;
  response->camera.pose = toPoseMsg(T_target_camera);
  Detection expected = known;
  expected.covariance = next->covariance;
  response->expected = toMsg(expected, *kept.part, kept.T_target_first).pose;
  response->message = "look from there";
  host_.show(T_target_camera, kept.camera);
}

bool ViewServices::lookInSecond(const ros::Time& not_before, const ros::Duration& timeout,
                                const Eigen::Isometry3d& T_target_camera, Answer* answer) {
  if (!second_) return false;
  const ros::Duration wait = timeout.isZero() ? ros::Duration(cell_.image_timeout) : timeout;
  const Frame frame = second_->await(not_before, wait);
  const std_msgs::Header& image = frame.image->header;
  const std::string& named = cell_.second_camera_frame;
  const auto T_target_second =
      host_.transform(answer->header.frame_id, named.empty() ? image.frame_id : named, image.stamp);
  const auto first = std::make_shared<const View>(answer->grey, answer->camera,
                                                  Eigen::Isometry3d::Identity(), params_.edges);
  const auto second =
      std::make_shared<const View>(toGrey(frame.image), toCamera(*frame.info, *frame.image),
                                   T_target_camera.inverse() * T_target_second, params_.edges);
  const planar_bin_picking::Looker looker(ofFixedCameras(params_));
  std::vector<Detection> kept;
  for (const Detection& detection : answer->result.detections) {
    const LookResult result =
        looker.look(detection, *answer->parts[detection.part], {first, second});
    if (agrees(result.status) || result.status == LookStatus::kNotSeen) {
      kept.push_back(result.detection);
    } else {
      answer->result.withheld.push_back(
          {detection, planar_bin_picking::Withheld::kContradicted, result.text});
    }
  }
  answer->result.detections = kept;
  return true;
}

}  // namespace planar_bin_picking_ros
