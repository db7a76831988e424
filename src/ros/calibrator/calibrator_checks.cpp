// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibrator_checks.h"

#include "planar_bin_picking/calibrate/board/missing_board.h"

#include <sstream>
#include <stdexcept>

namespace planar_bin_picking_ros {

using planar_bin_picking::BoardObservation;
using planar_bin_picking::CalibrationRun;
using planar_bin_picking::HandEyeResult;

namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;

std::string nameOf(const sensor_msgs::Image& image) {
  return "\"" + image.header.frame_id + "\", " + std::to_string(image.width) + " x " +
         std::to_string(image.height);
}

}  // namespace

void checkSameCamera(const Frame& first, const Frame& other) {
  const auto& a = *first.image;
  const auto& b = *other.image;
  if (a.header.frame_id == b.header.frame_id && a.width == b.width && a.height == b.height) return;
  throw std::runtime_error("the image is of another camera than the first (" + nameOf(b) +
                           ", was " + nameOf(a) +
                           "); look for a second driver on the topic, or begin anew");
}

void checkNear(const Eigen::Isometry3d& one, const Eigen::Isometry3d& other,
               const CalibratorParams& params, const std::string& what, const std::string& where) {
  const Eigen::Isometry3d off = one.inverse() * other;
  const double mm = 1e3 * off.translation().norm();
  const double deg = kDegrees * planar_bin_picking::rotationAngle(off.linear());
  if (mm <= params.reached_mm && deg <= params.reached_deg) return;  // NaN is never near
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(3);
  text << what << " " << mm << " mm and " << deg << " deg from " << where << "; allowed are "
       << params.reached_mm << " mm (reached_mm) and " << params.reached_deg
       << " deg (reached_deg)";
  throw std::runtime_error(text.str());
}

std::string whyNoBoard(const BoardObservation& seen, const cv::Mat& image,
                       const planar_bin_picking::Board& board) {
  if (seen.status == BoardObservation::Status::kBlurred) {
    return "the board is blurred; focus the camera, light the board";
  }
  return planar_bin_picking::whyBoardIsMissing({image}, board);
}

void explain(const CalibrationRun& run, const std::string& why_lost, HandEyeResult* result) {
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
    result->reasons.push_back("no sharp board was seen from " + std::to_string(lost) + of + ": " +
                              why_lost);
  }
  using End = CalibrationRun::End;
  if (run.end() == End::kNoPose) {
    result->reasons.push_back(
        "no further pose is left within the limits; widen the workspace, cone_deg, max_roll_deg or "
        "tilt_max_deg, or start with the board in the middle of the image");
  } else if (run.end() == End::kRefusals) {
    result->reasons.push_back("the robot refused refusals_max poses one after the other");
  }
}

}  // namespace planar_bin_picking_ros
