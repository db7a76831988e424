// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "robot_server/robot_session.h"

#include "shared/convert.h"
#include "shared/names.h"
#include "shared/timed_call.h"

#include <planar_bin_picking/LocatePart.h>
#include <planar_bin_picking/ReportPick.h>
#include <std_srvs/Trigger.h>

#include <stdexcept>

namespace planar_bin_picking_ros {

using planar_bin_picking::FaceFilter;
using planar_bin_picking::LocatedPart;
using planar_bin_picking::LocatePart;
using planar_bin_picking::PoseConvention;
using planar_bin_picking::ReportPick;
using planar_bin_picking::RobotCode;
using planar_bin_picking::RobotCommand;

namespace {

PoseConvention conventionOf(const std::string& name) {
  const auto convention = planar_bin_picking::poseConvention(name);
  if (!convention) {
    throw std::invalid_argument("~server/convention is '" + name +
                                "'; it must be kuka, fanuc, ur, abb, staubli or plain");
  }
  return *convention;
}

Eigen::Isometry3d flangeInTool(const RobotServerParams& params) {
  if (params.tool.empty()) return Eigen::Isometry3d::Identity();
  try {
    return planar_bin_picking::fromNumbers(params.tool, conventionOf(params.convention)).inverse();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("~server/tool: ") + error.what());
  }
}

RobotCode codeOf(const std::uint8_t status) {
  using Response = LocatePart::Response;
  switch (status) {
    case Response::OK:
      return RobotCode::kPose;
    case Response::NO_PART_FOUND:
    case Response::DEADLOCK:
      return RobotCode::kNothing;
    case Response::EMPTY:
      return RobotCode::kEmpty;
    case Response::NO_IMAGE:
    case Response::NO_TRANSFORM:
    case Response::BAD_IMAGE:
      return RobotCode::kAgain;
    default:
      return RobotCode::kSetUp;
  }
}

std::uint8_t faceOf(const FaceFilter face) {
  if (face == FaceFilter::kFront) return LocatePart::Request::FRONT;
  return face == FaceFilter::kBack ? LocatePart::Request::BACK : LocatePart::Request::ANY;
}

}  // namespace

RobotCell::RobotCell(const RobotServerParams& server, const ros::NodeHandle& node)
    : params(server),
      convention(conventionOf(server.convention)),
      T_tool_flange(flangeInTool(server)),
      nh(node) {
  status_ = nh.subscribe<std_msgs::String>(params.calibrator + "/" + kStatusTopic, 1,
                                           [this](const std_msgs::String::ConstPtr& status) {
                                             const std::lock_guard<std::mutex> lock(mutex_);
                                             calibration_ = status->data;
                                           });
}

std::size_t RobotCell::numbersInLine() const {
  constexpr std::size_t kAhead = 3, kNumbers = 2;  // code, parts left, face; of part and tool
  const std::size_t poses = 1 + (params.approach_mm > 0.0) + (params.retreat_mm > 0.0);
  return kAhead + (params.numbers ? kNumbers : 0) +
         poses * planar_bin_picking::poseNumbers(convention);
}

std::string RobotCell::calibration() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return calibration_;
}

std::string RobotSession::text(const RobotCode code, const std::string& words) const {
  return planar_bin_picking::textLine(code, words, cell_.convention, cell_.numbersInLine());
}

std::string RobotSession::answer(const std::string& line) {
  try {
    const RobotCommand command = planar_bin_picking::parseRobotLine(line, cell_.convention);
    switch (command.kind) {
      case RobotCommand::Kind::kHello:
        return text(RobotCode::kDone, "planar_bin_picking " + cell_.params.convention);
      case RobotCommand::Kind::kLocate:
        return locate(command);
      case RobotCommand::Kind::kNext:
        return next();
      case RobotCommand::Kind::kCalibrate:
        return calibrate(command.step);
      case RobotCommand::Kind::kReport:
        break;
    }
    return report(command.success);
  } catch (const std::invalid_argument& error) {
    return text(RobotCode::kBadLine, error.what());
  } catch (const std::exception& error) {
    return text(RobotCode::kSetUp, error.what());
  }
}

std::string RobotSession::locate(const RobotCommand& command) {
  waiting_.clear();
  current_.reset();
  LocatePart service;
  service.request.parts = command.parts;
  service.request.face = faceOf(command.face);
  if (command.T_base_flange) {
    if (cell_.params.flange_frame.empty())
      throw std::invalid_argument("the flange's pose was sent; name its frame in flange_frame");
    service.request.flange.header.frame_id = cell_.params.base_frame;
    service.request.flange.child_frame_id = cell_.params.flange_frame;
    service.request.flange.transform = toTransformMsg(*command.T_base_flange);
  }
  const std::string name = cell_.params.locator + "/locate_part";
  const CallEnd end = callWithin(cell_.nh, name, cell_.params.timeout, &service);
  if (end != CallEnd::kAnswered) {
    return text(RobotCode::kNoLocator,
                end == CallEnd::kLate ? name + " did not answer in time" : name + " is not there");
  }
  if (service.response.status != LocatePart::Response::OK)
    return text(codeOf(service.response.status), service.response.message);
  waiting_.assign(service.response.parts.begin(), service.response.parts.end());
  return offer(
      "none of the parts' files has a pick pose: write one, so that the robot knows where "
      "to go");
}

planar_bin_picking::RobotPose RobotSession::poseOf(
    const planar_bin_picking::LocatedPick& pick) const {
  const Eigen::Isometry3d T_base_tool = fromMsg(pick.pose);
  // Where the part's file says nothing, both are the pick pose itself.
  const auto isSaid = [&](const geometry_msgs::Pose& pose) {
    return (fromMsg(pose).translation() - T_base_tool.translation()).norm() > 0.0;
  };
  planar_bin_picking::RobotPose pose;
  pose.T_base_target = T_base_tool * cell_.T_tool_flange;
  if (const double before = 1e-3 * cell_.params.approach_mm; before > 0.0) {
    const Eigen::Isometry3d T_base_before =
        isSaid(pick.approach) ? fromMsg(pick.approach)
                              : T_base_tool * Eigen::Translation3d(0.0, 0.0, -before);
    pose.T_base_approach = T_base_before * cell_.T_tool_flange;
  }
  if (const double above = 1e-3 * cell_.params.retreat_mm; above > 0.0) {
    const Eigen::Isometry3d T_base_above =
        isSaid(pick.retreat) ? fromMsg(pick.retreat)
                             : Eigen::Translation3d(0.0, 0.0, above) * T_base_tool;
    pose.T_base_retreat = T_base_above * cell_.T_tool_flange;
  }
  return pose;
}

std::string RobotSession::offer(const std::string& otherwise) {
  while (!waiting_.empty()) {
    current_ = waiting_.front();
    waiting_.pop_front();
    if (current_->picks.empty()) continue;
    planar_bin_picking::RobotPose pose = poseOf(current_->picks.front());
    pose.left = waiting_.size();
    pose.face = current_->face == LocatedPart::FRONT ? planar_bin_picking::Face::kFront
                                                     : planar_bin_picking::Face::kBack;
    pose.part = current_->part;
    if (cell_.params.numbers) pose.numbers = {current_->part_number, current_->tool_number};
    pose.pick = current_->picks.front().name;
    return planar_bin_picking::poseLine(pose, cell_.convention);
  }
  current_.reset();
  return text(RobotCode::kSetUp, otherwise);
}

std::string RobotSession::next() {
  if (waiting_.empty()) {
    current_.reset();
    return text(RobotCode::kNothing, "nothing is left of the latest answer: locate again");
  }
  return offer("what is left has no pick pose");
}

std::string RobotSession::report(const bool success) {
  if (!current_) return text(RobotCode::kBadLine, "there is nothing to report on: locate first");
  ReportPick service;
  service.request.stamp = current_->header.stamp;
  service.request.child_frame = current_->child_frame;
  service.request.success = success;
  const std::string name = cell_.params.locator + "/report_pick";
  if (callWithin(cell_.nh, name, cell_.params.timeout, &service) != CallEnd::kAnswered)
    return text(RobotCode::kNoLocator, name + " does not answer");
  current_.reset();
  const bool goes_on = service.response.status == ReportPick::Response::NEXT;
  if (success || !goes_on) {
    waiting_.clear();  // the scene has changed, or nothing is left
    return text(success ? RobotCode::kDone : RobotCode::kNothing, service.response.message);
  }
  // The locator's next is where this one's failure leads; it stands among those that wait.
  while (!waiting_.empty() && waiting_.front().child_frame != service.response.next.child_frame)
    waiting_.pop_front();
  if (waiting_.empty()) waiting_.push_back(service.response.next);
  return offer("what is left has no pick pose");
}

std::string RobotSession::calibrate(const std::string& step) {
  if (step == "status") {
    const std::string status = cell_.calibration();
    if (status.empty())
      return text(RobotCode::kNoLocator, cell_.params.calibrator + " has not said anything");
    const auto begins = [&](const char* word) { return status.rfind(word, 0) == 0; };
    return text(begins("GOOD")                                              ? RobotCode::kDone
                : begins("running") || begins("waiting") || begins("ready") ? RobotCode::kAgain
                                                                            : RobotCode::kSetUp,
                status);
  }
  const std::string name =
      cell_.params.calibrator + "/" + (step == "add" ? std::string(kAddSampleService) : step);
  std_srvs::Trigger service;
  const CallEnd end = callWithin(cell_.nh, name, cell_.params.calibrator_timeout, &service);
  if (end != CallEnd::kAnswered) {
    return text(RobotCode::kNoLocator,
                end == CallEnd::kLate ? name + " did not answer in time" : name + " is not there");
  }
  return text(service.response.success ? RobotCode::kDone : RobotCode::kSetUp,
              service.response.message);
}

}  // namespace planar_bin_picking_ros
