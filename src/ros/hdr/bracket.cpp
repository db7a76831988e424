// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hdr/bracket.h"

#include "shared/convert_camera.h"

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

SteadyTime fromNow(const double seconds) {
  return std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                                std::chrono::duration<double>(seconds));
}

}  // namespace

std::string BracketTaker::failure(const double seconds, const Tally& tally) const {
  char text[300];
  if (inbox_->closed()) {
    std::snprintf(text, sizeof text, "the node shut down while it waited for a frame");
  } else if (tally.count == 0) {
    std::snprintf(
        text, sizeof text,
        "no frame came within %.3g s after the camera took %.3g ms; it dropped the frame, "
        "or it is slow: check its frame rate, raise ~hdr/frame_timeout",
        params_.frame_timeout, 1e3 * seconds);
  } else if (tally.shown > 0.0) {
    std::snprintf(
        text, sizeof text,
        "asked for %.3g ms, but the newest of %d frames since then looks like %.3g ms; the "
        "camera ignores the command or comes late, the scene moves, or its response is not "
        "that of ~hdr/merge: check automatic exposure and gain",
        1e3 * seconds, tally.count, 1e3 * tally.shown);
  } else {
    std::snprintf(
        text, sizeof text,
        "asked for %.3g ms, and %d frames since then are all dark or all white, which tells "
        "no exposure; fewer than ~hdr/blind_frames came in time: raise ~hdr/frame_timeout",
        1e3 * seconds, tally.count);
  }
  return text;
}

ExposedFrame BracketTaker::takeSingle(const double seconds) {
  const SteadyTime now = std::chrono::steady_clock::now();
  const SteadyTime deadline = fromNow(params_.frame_timeout);
  const ros::Time not_before = ros::Time::now();
  ask_();
  const auto frame = inbox_->wait({not_before, now}, deadline);
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
  const SteadyTime deadline = fromNow(params_.bracket_timeout);
  try {
    for (const double seconds : inOrder(params_.exposures_ms, single.seconds)) {
      if (logDistance(seconds, single.seconds) <= kSameExposure) continue;
      if (std::chrono::steady_clock::now() >= deadline) {
        throw std::runtime_error(std::to_string(known.size()) + " of the exposures took longer " +
                                 "than ~hdr/bracket_timeout; check the camera, or raise it");
      }
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

/// A trigger may answer only after its frame has come in: then wait() never waits, and this is all
/// that ends the search.
bool BracketTaker::mayAsk(const Tally& tally, const SteadyTime deadline) const {
  if (!params_.trigger_service.empty() && tally.count >= params_.triggers_max) return false;
  return std::chrono::steady_clock::now() < deadline;
}

ExposedFrame BracketTaker::takeOne(const double seconds, const std::vector<ExposedFrame>& known) {
  set_(seconds);
  SteadyTime after = std::chrono::steady_clock::now();
  const SteadyTime deadline = fromNow(params_.frame_timeout);
  Tally tally;
  while (mayAsk(tally, deadline)) {
    ask_();
    const auto frame = inbox_->wait({ros::Time(), after}, deadline);
    if (!frame) break;
    after = frame->received;
    ++tally.count;
    if (hasExposure(*frame, seconds, nearest(known, seconds), &tally)) return {*frame, seconds};
  }
  throw std::runtime_error(failure(seconds, tally));
}

bool BracketTaker::hasExposure(const Frame& frame, const double seconds,
                               const ExposedFrame& reference, Tally* tally) const {
  const auto ratio = planar_bin_picking::exposureRatio(toGrey(reference.frame.image),
                                                       toGrey(frame.image), params_.merge);
  if (!ratio) return tally->count >= params_.blind_frames;
  tally->shown = *ratio * reference.seconds;
  return logDistance(tally->shown, seconds) <= std::log1p(params_.exposure_tolerance);
}

}  // namespace planar_bin_picking_ros
