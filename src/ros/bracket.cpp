// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bracket.h"

#include "convert.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace planar_bin_picking_ros {

namespace {

constexpr double kSameExposure = 0.01;  // relative

double logDistance(const double a, const double b) { return std::abs(std::log(a / b)); }

/// So that each exposure has a near one before it to be held against: from the single exposure
/// down, then from it up.
std::vector<double> inOrder(const std::vector<double>& exposures_ms, const double single) {
  std::vector<double> shorter, longer;
  for (const double ms : exposures_ms) (1e-3 * ms < single ? shorter : longer).push_back(1e-3 * ms);
  std::sort(shorter.rbegin(), shorter.rend());
  std::sort(longer.begin(), longer.end());
  shorter.insert(shorter.end(), longer.begin(), longer.end());
  return shorter;
}

const ExposedFrame& nearest(const std::vector<ExposedFrame>& known, const double seconds) {
  return *std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return logDistance(a.seconds, seconds) < logDistance(b.seconds, seconds);
  });
}

std::string failure(const double seconds, const int count, const double shown,
                    const double timeout) {
  char text[300];
  if (count == 0) {
    std::snprintf(
        text, sizeof text,
        "no frame came within %.3g s after the camera took %.3g ms; it dropped the frame, "
        "or it is slow: check its frame rate, raise ~hdr/frame_timeout",
        timeout, 1e3 * seconds);
  } else {
    std::snprintf(
        text, sizeof text,
        "asked for %.3g ms, but the newest of %d frames since then looks like %.3g ms; the "
        "camera ignores the command or comes late, the scene moves, or its response is not "
        "that of ~hdr/merge: check automatic exposure and gain",
        1e3 * seconds, count, 1e3 * shown);
  }
  return text;
}

}  // namespace

ExposedFrame BracketTaker::takeSingle(const double seconds) {
  const SteadyTime now = std::chrono::steady_clock::now();
  const auto timeout = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(params_.frame_timeout));
  const ros::Time not_before = ros::Time::now();
  ask_();
  const auto frame = inbox_->wait({not_before, now}, now + timeout);
  if (!frame) {
    throw std::runtime_error(
        "no frame came within ~hdr/frame_timeout; check that the camera runs and that its clock "
        "and this one agree");
  }
  return {*frame, seconds};
}

std::vector<ExposedFrame> BracketTaker::take(const ExposedFrame& single) {
  std::vector<ExposedFrame> known = {single};
  std::string error;
  try {
    for (const double seconds : inOrder(params_.exposures_ms, single.seconds)) {
      if (logDistance(seconds, single.seconds) > kSameExposure)
        known.push_back(takeOne(seconds, known));
    }
  } catch (const std::exception& reason) {
    error = reason.what();
  }
  try {
    takeOne(single.seconds, {single});
  } catch (const std::exception& reason) {
    if (error.empty()) error = std::string("back to the single exposure: ") + reason.what();
  }
  if (!error.empty()) throw BracketFailure(error);
  return known;
}

ExposedFrame BracketTaker::takeOne(const double seconds, const std::vector<ExposedFrame>& known) {
  set_(seconds);
  SteadyTime after = std::chrono::steady_clock::now();
  const auto deadline = after + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                    std::chrono::duration<double>(params_.frame_timeout));
  double shown = 0.0;
  for (int count = 0;; ++count) {
    ask_();
    const auto frame = inbox_->wait({ros::Time(), after}, deadline);
    if (!frame) throw std::runtime_error(failure(seconds, count, shown, params_.frame_timeout));
    after = frame->received;
    if (hasExposure(*frame, seconds, nearest(known, seconds), count, &shown))
      return {*frame, seconds};
  }
}

bool BracketTaker::hasExposure(const Frame& frame, const double seconds,
                               const ExposedFrame& reference, const int count,
                               double* shown) const {
  const auto ratio = planar_bin_picking::exposureRatio(toGrey(reference.frame.image),
                                                       toGrey(frame.image), params_.merge);
  if (!ratio) return count + 1 >= params_.blind_frames;
  *shown = *ratio * reference.seconds;
  return logDistance(*shown, seconds) <= std::log1p(params_.exposure_tolerance);
}

}  // namespace planar_bin_picking_ros
