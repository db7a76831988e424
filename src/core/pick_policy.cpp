// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick_policy.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr int kPatch = 24;  // pixels across the kept surroundings

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

/// Mean absolute difference, grey levels; 0 where there is nothing to compare: nothing tells of a
/// change then.
double difference(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty() || b.empty()) return 0.0;
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

/// Whether a tool of that radius and height touches no wall on its way out of the bin.
bool toolIsFree(const Eigen::Isometry3d& T_target_pick, const PickBin& bin, double room,
                double height) {
  constexpr int kSteps = 20;
  const Eigen::Isometry3d T_bin_pick = bin.T_bin_target * T_target_pick;
  const Eigen::Vector3d tip = T_bin_pick.translation(), axis = T_bin_pick.linear().col(2);
  // The tool stands on the part against the stroke; what is above the walls is free.
  const double rise = -axis.z(), below = bin.max.z() - tip.z();
  double length = rise > 0.0 ? std::max(0.0, below / rise) : 0.0;
  if (height > 0.0) length = std::min(length, height);
  for (int i = 0; i <= kSteps; ++i) {
    const Eigen::Vector3d p = tip - axis * (length * i / kSteps);
    if (p.x() - room < bin.min.x() || p.x() + room > bin.max.x() || p.y() - room < bin.min.y() ||
        p.y() + room > bin.max.y())
      return false;
  }
  return true;
}

/// Whether something covers the face where the tool goes, or within `radius` about it.
bool isCovered(const PickFace& face, const Eigen::Isometry3d& T_target_pick, double radius) {
  const Eigen::Vector3d pick = face.T_target_part.inverse() * T_target_pick.translation();
  const double reach = radius + 0.5 * face.cell_size;
  return std::any_of(face.covered.begin(), face.covered.end(), [&](const Eigen::Vector2d& cell) {
    return (cell - pick.head<2>()).norm() <= reach;
  });
}

}  // namespace

PickPolicy::PickPolicy(const PickParams& params) : params_(params) {
  PickParams::fields(params_, [](const char* key, auto value, auto min, auto max) {
    if (value >= min && value <= max) return;
    std::ostringstream text;
    text << key << " is " << value << ", must lie in " << min << " .. " << max;
    throw std::invalid_argument(text.str());
  });
}

PickPolicy::Failure* PickPolicy::find(const PickCandidate& candidate) {
  for (Failure& failure : failures_) {
    if (failure.part == candidate.part &&
        (failure.center - candidate.center).norm() <= params_.same_place)
      return &failure;
  }
  return nullptr;
}

PickTool PickPolicy::toolOf(const PickCandidate& candidate) const {
  return {candidate.tool.radius.value_or(params_.tool_radius),
          candidate.tool.height.value_or(params_.tool_height)};
}

int PickPolicy::recall(const PickCandidate& candidate) {
  Failure* const failure = find(candidate);
  if (failure == nullptr) return 0;
  if (difference(failure->surroundings, candidate.surroundings) <= params_.changed_grey)
    return failure->count;
  failures_.erase(failures_.begin() + (failure - failures_.data()));
  return 0;
}

std::optional<Refused> PickPolicy::dropBarred(const PickCandidate& candidate,
                                              const std::optional<PickBin>& bin,
                                              PickPlan::Offer* offer) const {
  const PickTool tool = toolOf(candidate);
  const double radius = *tool.radius, room = radius + params_.wall_clearance;
  const auto& picks = candidate.T_target_pick;
  std::size_t covered = 0;
  for (std::size_t k = 0; k < picks.size(); ++k) {
    if (radius > 0.0 && bin && !toolIsFree(picks[k], *bin, room, *tool.height)) continue;
    if (radius > 0.0 && isCovered(candidate.face, picks[k], radius)) {
      ++covered;
    } else {
      offer->picks.push_back(k);
    }
  }
  if (!offer->picks.empty() || picks.empty()) return std::nullopt;
  return covered > 0
             ? Refused{offer->candidate, PickRefusal::kOccluded,
                       format("something lies where a tool of radius %.3f m would go", radius)}
             : Refused{offer->candidate, PickRefusal::kWall,
                       format("a tool of radius %.3f m would touch the bin's wall", radius)};
}

std::optional<Refused> PickPolicy::refusal(const PickCandidate& candidate,
                                           const PickPlan::Offer& offer) const {
  const auto refuse = [&](PickRefusal reason, const std::string& text) {
    return Refused{offer.candidate, reason, text};
  };
  if (candidate.score < params_.score_min) {
    return refuse(PickRefusal::kLowScore,
                  format("score %.2f, at least %.2f", candidate.score, params_.score_min));
  }
  if (candidate.visible_fraction < params_.visible_min) {
    return refuse(PickRefusal::kOccluded, format("%.2f of it visible, at least %.2f",
                                                 candidate.visible_fraction, params_.visible_min));
  }
  if (candidate.tilt_deg > params_.tilt_max_deg) {
    return refuse(PickRefusal::kTilt, format("tilted by %.1f degrees, at most %.1f",
                                             candidate.tilt_deg, params_.tilt_max_deg));
  }
  if (offer.failures >= params_.failures_max) {
    return refuse(PickRefusal::kFailedBefore,
                  format("%d picks failed here, and the scene is as it was", offer.failures));
  }
  return std::nullopt;
}

PickPlan PickPolicy::plan(const std::vector<PickCandidate>& candidates,
                          const std::optional<PickBin>& bin) {
  PickPlan plan;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    PickPlan::Offer offer{i, {}, recall(candidates[i])};
    const auto barred = dropBarred(candidates[i], bin, &offer);
    auto refused = refusal(candidates[i], offer);
    if (!refused) refused = barred;
    if (refused) {
      plan.refused.push_back(*refused);
    } else {
      plan.offers.push_back(std::move(offer));
    }
  }
  std::stable_sort(plan.offers.begin(), plan.offers.end(),
                   [](const auto& a, const auto& b) { return a.failures < b.failures; });
  return plan;
}

void PickPolicy::fail(const PickCandidate& candidate) {
  if (Failure* const known = find(candidate)) {
    ++known->count;
    known->surroundings = candidate.surroundings;
    return;
  }
  failures_.push_back({candidate.part, candidate.center, candidate.surroundings, 1});
}

void PickPolicy::succeed(const PickCandidate& candidate) {
  if (const Failure* const known = find(candidate))
    failures_.erase(failures_.begin() + (known - failures_.data()));
}

cv::Mat cutSurroundings(const cv::Mat& grey, const Camera& camera,
                        const Eigen::Isometry3d& T_camera_part, const Eigen::Vector3d& center,
                        double radius) {
  const Eigen::Vector3d c = T_camera_part * center;
  const double left = camera.project(c - Eigen::Vector3d(radius, 0.0, 0.0)).x();
  const double right = camera.project(c + Eigen::Vector3d(radius, 0.0, 0.0)).x();
  const Eigen::Vector2d p = camera.project(c);
  const int half = static_cast<int>(std::ceil(0.5 * (right - left)));
  const cv::Rect square(static_cast<int>(std::lround(p.x())) - half,
                        static_cast<int>(std::lround(p.y())) - half, 2 * half + 1, 2 * half + 1);
  const cv::Rect seen = square & cv::Rect(0, 0, grey.cols, grey.rows);
  if (seen != square) return {};
  cv::Mat patch;
  cv::resize(grey(square), patch, {kPatch, kPatch}, 0, 0, cv::INTER_AREA);
  patch.convertTo(patch, CV_32F, grey.depth() == CV_16U ? 1.0 / 256.0 : 1.0);
  patch -= cv::mean(patch)[0];
  return patch;
}

std::string deadlockHint(const std::vector<Refused>& refused) {
  std::map<PickRefusal, int> counts;
  for (const Refused& part : refused) ++counts[part.reason];
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most == counts.end()) return "nothing was found";
  const std::string parts = format("most (%d of %zu) ", most->second, refused.size());
  switch (most->first) {
    case PickRefusal::kLowScore:
      return parts + "score too low: check light and focus, or lower pick/score_min";
    case PickRefusal::kOccluded:
      return parts +
             "are covered: stir or shake the bin, lower pick/visible_min, or use a thinner tool";
    case PickRefusal::kTilt:
      return parts + "lie too steep: stir or shake the bin, or raise pick/tilt_max_deg";
    case PickRefusal::kWall:
      return parts +
             "lie at the wall: shake the bin, give the part a pick pose farther inside, or "
             "use a thinner tool";
    case PickRefusal::kFailedBefore:
      return parts +
             "could not be picked before: look at the gripper and at the pick poses, or stir "
             "the bin";
  }
  return "";
}

}  // namespace planar_bin_picking
