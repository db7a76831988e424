// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/health/health.h"

#include "hand_eye/calibration_age.h"
#include "shared/convert.h"
#include "shared/names.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <planar_bin_picking/RefusedPart.h>
#include <ros/console.h>
#include <std_msgs/Header.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

namespace planar_bin_picking_ros {

using diagnostic_msgs::DiagnosticStatus;
using planar_bin_picking::RefusedPart;
using Response = planar_bin_picking::LocatePart::Response;

namespace {

const char* nameOfStatus(const std::uint8_t status) {
  constexpr const char* kNames[] = {"OK",
                                    "NO_PART_FOUND",
                                    "NO_IMAGE",
                                    "UNKNOWN_PART",
                                    "NO_TRANSFORM",
                                    "BAD_CAMERA_INFO",
                                    "BAD_IMAGE",
                                    "BAD_REQUEST",
                                    "BAD_BIN",
                                    "INTERNAL_ERROR",
                                    "DEADLOCK",
                                    "BAD_PLANE",
                                    "BAD_PART_SIZE",
                                    "EMPTY"};
  return status < std::size(kNames) ? kNames[status] : "?";
}

/// What needs a person is an error, what a robot program goes on from is a warning.
std::uint8_t levelOf(const std::uint8_t status) {
  switch (status) {
    case Response::OK:
    case Response::EMPTY:
      return DiagnosticStatus::OK;
    case Response::NO_PART_FOUND:
    case Response::DEADLOCK:
    case Response::UNKNOWN_PART:
    case Response::BAD_REQUEST:
    case Response::BAD_PART_SIZE:
      return DiagnosticStatus::WARN;
    default:
      return DiagnosticStatus::ERROR;
  }
}

double since(const SteadyTime then) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

/// How good and how old one file of the calibration is.
/// @return  what to say where that is not good
std::string describeCalibration(const std::string& key, const std::string& path,
                                diagnostic_updater::DiagnosticStatusWrapper* status) {
  if (path.empty()) {
    status->add(key, "not named in the cell's file");
    return "";
  }
  status->add(key, path);
  try {
    const CalibrationAge age = calibrationAge(path);
    status->add(key + ", verdict", age.verdict.empty() ? "not said" : age.verdict);
    status->add(key + ", age in days", age.days);
    return age.verdict == "POOR" || age.verdict == "REFUSED" ? key + " is " + age.verdict : "";
  } catch (const std::runtime_error& error) {
    status->add(key + ", error", error.what());
    return error.what();
  }
}

}  // namespace

Health::Health(const ImageSource& source, const PartStore& parts, const Tuning& tuning,
               CheckCamera check_camera, ros::NodeHandle nh)
    : source_(source),
      parts_(parts),
      tuning_(tuning),
      check_camera_(std::move(check_camera)),
      updater_(nh, nh, nh.getNamespace()),
      heartbeat_(nh.advertise<std_msgs::Header>(kHeartbeatTopic, 1)) {
  updater_.setHardwareID(source_.topic());
  updater_.add("camera", this, &Health::camera);
  updater_.add("calibration", [this](Status& status) { calibration(status); });
  updater_.add("parts", [this](Status& status) { this->parts(status); });
  updater_.add("calls", this, &Health::calls);
  constexpr double kPeriod = 1.0;  // s
  timer_ = nh.createWallTimer(ros::WallDuration(kPeriod),
                              [this](const ros::WallTimerEvent&) { beat(); });
  const boost::function<bool(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&)> serve =
      [this](std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
        response.success = true;
        response.message = describe(*tuning_.current());
        return true;
      };
  parameters_ = nh.advertiseService(kParametersService, serve);
}

void Health::beat() {
  std_msgs::Header now;
  now.stamp = ros::Time::now();
  heartbeat_.publish(now);
  updater_.force_update();
}

void Health::count(const int change) {
  const std::lock_guard<std::mutex> lock(mutex_);
  under_way_ += change;
}

void Health::called(const Response& response) {
  const double threshold = tuning_.current()->locator.score.threshold;
  const std::lock_guard<std::mutex> lock(mutex_);
  latest_ = response;
  latest_threshold_ = threshold;
  called_ = std::chrono::steady_clock::now();
  ++by_status_[response.status];
  deadlocks_in_a_row_ = response.status == Response::DEADLOCK ? deadlocks_in_a_row_ + 1 : 0;
}

namespace {

constexpr double kOld = 5.0;  // s without an image that comes of itself, or without a pair

}  // namespace

bool Health::hasNoPairs(const ImageSource::Traffic& traffic, const std::optional<Frame>& newest) {
  constexpr double kPatience = 2.0;  // s: the camera_info of the latest image may be on its way
  const bool is_paired = newest && (newest->image->header.stamp == traffic.images.stamp() ||
                                    since(newest->received) < kOld);
  if (is_paired || traffic.images.count() == 0) {
    unpaired_.reset();
  } else if (!unpaired_) {
    unpaired_ = std::chrono::steady_clock::now();
  }
  return unpaired_ && since(*unpaired_) > kPatience;
}

void Health::camera(Status& status) {
  const bool has_trigger = !tuning_.current()->cell.trigger_service.empty();
  const ImageSource::Traffic traffic = source_.traffic();
  const std::size_t fresh = traffic.images.count() - images_;
  const double rate = static_cast<double>(fresh) / std::max(1e-3, since(looked_));
  images_ = traffic.images.count();
  looked_ = std::chrono::steady_clock::now();
  const bool has_image = traffic.images.count() > 0;
  const double age = has_image ? since(traffic.images.received()) : -1.0;
  const auto newest = source_.newest();
  if (!traffic.has_publisher) {
    status.summary(DiagnosticStatus::ERROR, "nobody publishes " + source_.topic());
  } else if (has_trigger && !has_image) {
    status.summary(DiagnosticStatus::OK, "images come on request; none was asked for yet");
  } else if (!has_image || (!has_trigger && age > kOld)) {
    status.summary(DiagnosticStatus::ERROR, "no image comes on " + source_.topic());
  } else if (hasNoPairs(traffic, newest)) {
    const std::string why = source_.whyNoPair();
    status.summary(DiagnosticStatus::ERROR,
                   why.empty() ? "no image has a camera_info of the same stamp" : why);
  } else if (traffic.images.stamp().isZero()) {
    status.summary(DiagnosticStatus::ERROR,
                   "images have a stamp of zero; let the driver fill in header.stamp");
  } else {
    status.summary(DiagnosticStatus::OK, "images come");
    try {
      if (newest) check_camera_(*newest);
    } catch (const std::exception& error) {
      status.summary(DiagnosticStatus::ERROR, error.what());
    }
  }
  status.add("topic", source_.topic());
  if (newest) {
    status.add("frame", newest->image->header.frame_id);
    status.add("width", newest->image->width);
    status.add("height", newest->image->height);
  }
  status.add("rate in Hz", rate);
  status.add("age of the latest image in s", age);
  status.add("images", traffic.images.count());
  status.add("camera_infos", traffic.infos.count());
  warn(status);
}

namespace {

/// What a text says, whatever its numbers are at this second.
std::string withoutDigits(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(),
                            [](unsigned char c) { return std::isdigit(c) != 0; }),
             text.end());
  return text;
}

}  // namespace

void Health::warn(const Status& status) {
  constexpr double kAgain = 60.0;  // s
  const std::string text = status.level == DiagnosticStatus::OK ? "" : status.message;
  if (withoutDigits(text) == withoutDigits(warning_) && (text.empty() || since(warned_) < kAgain))
    return;
  const auto newest = source_.newest();
  const std::string frame = newest ? ", frame '" + newest->image->header.frame_id + "'" : "";
  if (text.empty()) {
    ROS_INFO_STREAM("camera on " << source_.topic() << frame << ": is well again");
  } else {
    ROS_WARN_STREAM("camera on " << source_.topic() << frame << ": " << text);
  }
  warning_ = text;
  warned_ = std::chrono::steady_clock::now();
}

void Health::calibration(Status& status) {
  constexpr double kAgain = 60.0;  // s; it changes by the day
  if (calibration_read_ != SteadyTime{} && since(calibration_read_) < kAgain) {
    status.summary(calibration_);
    status.values = calibration_.values;
    return;
  }
  const auto settings = tuning_.current();
  std::string trouble;
  for (const auto& [key, path] : {std::pair{"camera_info_file", settings->cell.camera_info_file},
                                  std::pair{"hand_eye_file", settings->cell.hand_eye_file}}) {
    const std::string text = describeCalibration(key, path, &status);
    if (!text.empty()) trouble += (trouble.empty() ? "" : "; ") + text;
  }
  if (!trouble.empty()) {
    status.summary(DiagnosticStatus::WARN, trouble);
  } else {
    status.summary(DiagnosticStatus::OK, "nothing speaks against it");
  }
  calibration_ = status;
  calibration_read_ = std::chrono::steady_clock::now();
}

void Health::parts(Status& status) const {
  const auto library = parts_.current();
  const std::string trouble = parts_.trouble();
  std::string broken;
  for (const auto& entry : library->errors()) broken += (broken.empty() ? "" : ", ") + entry.first;
  if (!trouble.empty()) {
    status.summary(DiagnosticStatus::ERROR, "the parts folder cannot be read: " + trouble);
  } else if (library->parts().empty()) {
    status.summary(DiagnosticStatus::ERROR, "there is no part that can be located");
  } else if (!broken.empty()) {
    status.summary(DiagnosticStatus::WARN, "not available: " + broken);
  } else {
    status.summary(DiagnosticStatus::OK, "all parts could be read");
  }
  status.add("folder", library->folder());
  status.add("available", library->parts().size());
  for (const auto& [name, error] : library->errors()) status.add("part " + name, error);
}

void Health::calls(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::size_t calls = 0;
  for (const auto& entry : by_status_) calls += entry.second;
  if (calls == 0) {
    status.summary(DiagnosticStatus::OK, "no call yet");
  } else {
    status.summary(levelOf(latest_.status),
                   std::string(nameOfStatus(latest_.status)) + ": " + latest_.message);
    describeLatest(status);
  }
  status.add("calls under way", under_way_);
  status.add("calls", calls);
  status.add("deadlocks in a row", deadlocks_in_a_row_);
  for (const auto& [code, count] : by_status_)
    status.add(std::string("calls that ended with ") + nameOfStatus(code), count);
}

void Health::describeLatest(Status& status) const {
  status.add("latest, s ago", since(called_));
  status.add("found", latest_.parts.size() + latest_.refused.size());
  status.add("offered", latest_.parts.size());
  std::map<std::uint8_t, std::size_t> reasons;
  for (const auto& refused : latest_.refused) ++reasons[refused.reason];
  for (const auto& [reason, count] : reasons)
    status.add(std::string("refused, ") + nameOfReason(reason), count);
  double seconds = 0.0;
  for (const auto& time : latest_.times)
    if (time.stage != "wait") seconds += time.seconds;
  status.add("seconds without waiting", seconds);
  if (!latest_.parts.empty()) {
    status.add("score of the first", latest_.parts.front().score);
    status.add("score margin", latest_.parts.front().score - latest_threshold_);
  }
  status.add("filling", latest_.filling);
}

}  // namespace planar_bin_picking_ros
