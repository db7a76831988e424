// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/pick_policy.h"

#include "planar_bin_picking/pick/overlap.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking {
namespace {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

/// Why it does not lie in the bin, if so.
std::optional<std::string> outsideOf(const PickBin& bin, const PickCandidate& candidate) {
  const Eigen::Matrix3d R_bin_target = bin.T_bin_target.linear();
  const Eigen::Vector3d center = bin.T_bin_target * candidate.center;
  const Eigen::Matrix3d covariance =
      R_bin_target * candidate.center_covariance * R_bin_target.transpose();
  for (int axis = 0; axis < 3; ++axis) {
    const double margin = boxMargin(std::sqrt(std::max(0.0, covariance(axis, axis))));
    const double over = std::max(bin.min[axis] - center[axis], center[axis] - bin.max[axis]);
    if (over <= margin) continue;
    return format("its face's centre lies %.3f m outside of the bin's box along %c, margin %.3f m",
                  over, "xyz"[axis], margin);
  }
  return std::nullopt;
}

/// Whether a tool of that radius and height touches no wall between its approach and the contact.
/// On its way straight up it reaches no farther to the side than at the contact.
bool toolIsFree(const Eigen::Isometry3d& T_target_pick, const PickBin& bin, double room,
                double height, double approach) {
  constexpr int kSteps = 20;
  const Eigen::Isometry3d T_bin_pick = bin.T_bin_target * T_target_pick;
  const Eigen::Vector3d tip = T_bin_pick.translation(), axis = T_bin_pick.linear().col(2);
  // The tool stands on the part against the stroke; what is above the walls is free.
  const double rise = -axis.z(), below = bin.max.z() - tip.z();
  double length = rise > 0.0 ? std::max(0.0, below / rise) : 0.0;
  if (height > 0.0) length = std::min(length, height + approach);
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

/// Why it has to be looked at once more, if so.
std::optional<std::string> unsureOf(const PickCandidate& candidate, const PickParams& params) {
  if (params.depth_sigma_max > 0.0 && !(candidate.depth_sigma <= params.depth_sigma_max)) {
    return format("its depth is known to %.2f mm, at most %.2f", 1e3 * candidate.depth_sigma,
                  1e3 * params.depth_sigma_max);
  }
  if (params.tilt_sigma_max > 0.0 && !(candidate.tilt_sigma <= params.tilt_sigma_max)) {
    return format("its tilt is known to %.4f rad, at most %.4f", candidate.tilt_sigma,
                  params.tilt_sigma_max);
  }
  return std::nullopt;
}

/// What the matter is with such parts, and what helps.
const char* remedyFor(PickRefusal reason) {
  switch (reason) {
    case PickRefusal::kLowScore:
      return "have too low a score: check light and focus, or lower pick/score_min";
    case PickRefusal::kOccluded:
      return "are covered: stir or shake the bin, lower pick/visible_min, or use a thinner tool";
    case PickRefusal::kTilt:
      return "lie too steep: stir or shake the bin, or raise pick/tilt_max_deg";
    case PickRefusal::kWall:
      return "lie at the wall: shake the bin, give the part a pick pose farther inside, or use a "
             "thinner tool";
    case PickRefusal::kNoRoom:
      return "have no room for the tool beside them: pick others first, give the part a pick pose "
             "elsewhere, or use a slimmer tool";
    case PickRefusal::kFailedBefore:
      return "could not be picked before: look at the gripper and at the pick poses, or stir the "
             "bin";
    case PickRefusal::kOutside:
      return "lie outside of the cell's distances, its bin or its region: put them back into the "
             "bin, "
             "or correct the numbers in the cell's file";
    case PickRefusal::kNoPickPose:
      return "show a face for which their file has no pick pose: give it one, or have them turned "
             "over";
    case PickRefusal::kWrongFace:
      return "lie with the other face up than asked for: ask for the face ANY, or have them turned "
             "over";
    case PickRefusal::kNeedsView:
      return "are not known well enough: look once more (refine_part), or raise "
             "pick/depth_sigma_max and pick/tilt_sigma_max";
    case PickRefusal::kContradicted:
      return "are not where the first camera has them, as the second one shows: check where the "
             "cameras are said to be";
    case PickRefusal::kBeyondMaxParts:
      return "are more than max_parts asks for";
  }
  return "";
}

struct RangeCheck {
  template <class Value>
  void operator()(const char* key, Value value, Value min, Value max) const {
    if (value >= min && value <= max) return;
    std::ostringstream text;
    text << key << " is " << value << ", must lie in " << min << " .. " << max;
    throw std::invalid_argument(text.str());
  }
  void operator()(const char*, const std::vector<double>&) const {}  // toolBodies looks at these
};

// A part that carries another one, be it by a corner, may be held down by all its weight: of such
// thin plates every fifth pick fails, of those that lie free not one in a hundred. The shares that
// are told visible are known to some 0.02.
constexpr double kFree = 0.97, kCarries = 0.9;
// What made a pick fail is mostly so still where the part was dragged aside: two of three such
// picks fail again, so what only may be held down comes first.
constexpr double kDragged = 0.5;

/// What the order looks at.
PickPlace placeOf(const PickCandidate& candidate, const double visible,
                  const std::optional<PickBin>& bin) {
  PickPlace place;
  place.rank = candidate.confirmed * visible * visible * (visible < kFree ? kCarries : 1.0);
  place.center_target = candidate.center;
  place.height = candidate.center.z();
  if (!bin) return place;
  const Eigen::Vector3d x_bin = bin->T_bin_target * candidate.center;
  place.height = x_bin.z();
  place.wall_distance = std::min({x_bin.x() - bin->min.x(), bin->max.x() - x_bin.x(),
                                  x_bin.y() - bin->min.y(), bin->max.y() - x_bin.y()});
  const Eigen::Vector3d from_middle = x_bin - 0.5 * (bin->min + bin->max);
  place.turn = std::atan2(from_middle.x(), from_middle.y()) / (2.0 * EIGEN_PI);
  if (place.turn < 0.0) place.turn += 1.0;
  return place;
}

PickInstance instanceOf(const PickCandidate& candidate) {
  return {candidate.part, candidate.center, candidate.model ? candidate.model->radius() : 0.0,
          candidate.surroundings};
}

/// Adds to each face's covered cells those over which another of the parts lies.
/// @return  share of each face that neither the picture nor the other parts show to be covered
std::vector<double> coverByOthers(std::vector<PickCandidate>* candidates) {
  std::vector<LyingFace> faces;
  for (const PickCandidate& c : *candidates)
    faces.push_back({c.model.get(), c.face.up, c.face.T_target_part, c.face.covered});
  std::vector<double> visible;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    PickCandidate& own = (*candidates)[i];
    visible.push_back(own.visible_fraction);
    if (!own.model) continue;
    std::set<int> below;
    for (std::size_t k = 0; k < faces.size(); ++k) {
      // What another view contradicts is not there.
      if (k == i || !faces[k].part || (*candidates)[k].withheld == PickRefusal::kContradicted)
        continue;
      const auto cells = cellsBelow(faces[i], faces[k]);
      below.insert(cells.begin(), cells.end());
    }
    const FaceGrid& grid = own.model->faceGrid();
    own.face.cell_size = grid.cellSize();
    for (const int cell : below)
      own.face.covered.push_back(grid.cells()[static_cast<std::size_t>(cell)]);
    const double all = static_cast<double>(std::max<std::size_t>(1, grid.cells().size()));
    visible.back() = std::min(visible.back(), 1.0 - static_cast<double>(below.size()) / all);
  }
  return visible;
}

}  // namespace

double boxMargin(double sigma) {
  constexpr double kBoxIsKnownTo = 0.005;  // m; what measuring a bin in with a robot comes to
  constexpr double kSigmas = 3.0;
  constexpr double kMostOfPosition = 0.015;  // m; a vague pose must not reach into the next bin
  return kBoxIsKnownTo + std::min(kSigmas * sigma, kMostOfPosition);
}

PickPolicy::PickPolicy(const PickParams& params) { use(params); }

void PickPolicy::use(const PickParams& params) {
  PickParams::fields(params, RangeCheck{});
  bodies_ = toolBodies(params.tool_boxes, params.tool_cylinders);
  params_ = params;
  failures_.use(params.same_place, params.changed_grey);
}

PickTool PickPolicy::toolOf(const PickCandidate& candidate) const {
  return {candidate.tool.radius.value_or(params_.tool_radius),
          candidate.tool.height.value_or(params_.tool_height)};
}

std::optional<PickPolicy::Bar> PickPolicy::barAt(const std::vector<PickCandidate>& candidates,
                                                 const std::optional<PickBin>& bin,
                                                 std::size_t candidate, std::size_t pick) const {
  const PickCandidate& own = candidates[candidate];
  const PickTool tool = toolOf(own);
  const double radius = *tool.radius, room = radius + params_.wall_clearance;
  const Eigen::Isometry3d& T_target_pick = own.T_target_pick[pick];
  if (radius > 0.0 && bin && !toolIsFree(T_target_pick, *bin, room, *tool.height, own.approach))
    return Bar{PickRefusal::kWall,
               format("a tool of radius %.3f m would touch the bin's wall", radius)};
  if (radius > 0.0 && isCovered(own.face, T_target_pick, radius))
    return Bar{PickRefusal::kOccluded,
               format("something lies where a tool of radius %.3f m would go", radius)};
  if (bodies_.empty()) return std::nullopt;
  if (own.model &&
      touchesOwnPart(bodies_, *own.model, own.face.T_target_part.inverse() * T_target_pick))
    return Bar{PickRefusal::kNoRoom,
               "the tool would touch the part itself: open its fingers wider (pick/tool_boxes), or "
               "move or turn the pick pose"};
  const ToolWay in_bin{bodies_, T_target_pick, own.approach, params_.wall_clearance};
  if (bin && touchesBin(in_bin, *bin))
    return Bar{PickRefusal::kWall, "the tool would touch the bin's wall or its floor"};
  const ToolWay way{bodies_, T_target_pick, own.approach, params_.tool_clearance};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const PickCandidate& other = candidates[i];
    if (i != candidate && other.model && touchesPart(way, {other.model, other.face.T_target_part}))
      return Bar{PickRefusal::kNoRoom, "the tool would touch another part, " + other.part};
  }
  const bool is_strange = params_.tool_edges > 0.0 && pick < own.strange_edges.size() &&
                          own.strange_edges[pick] > params_.tool_edges;
  if (!is_strange) return std::nullopt;
  return Bar{PickRefusal::kNoRoom,
             format("the tool would touch something that nobody knows: %.0f mm of edges below it",
                    1e3 * own.strange_edges[pick])};
}

std::optional<Refused> PickPolicy::dropBarred(const std::vector<PickCandidate>& candidates,
                                              const std::optional<PickBin>& bin,
                                              PickPlan::Offer* offer) const {
  const PickCandidate& candidate = candidates[offer->candidate];
  std::map<PickRefusal, std::string> bars;  // of the last pick pose with it
  for (std::size_t k = 0; k < candidate.T_target_pick.size(); ++k) {
    if (const auto bar = barAt(candidates, bin, offer->candidate, k)) {
      bars[bar->reason] = bar->text;
    } else {
      offer->picks.push_back(k);
    }
  }
  if (!offer->picks.empty() || candidate.T_target_pick.empty()) return std::nullopt;
  for (const auto reason : {PickRefusal::kOccluded, PickRefusal::kNoRoom, PickRefusal::kWall})
    if (bars.count(reason) > 0) return Refused{offer->candidate, reason, bars[reason]};
  return std::nullopt;  // there is no other bar
}

std::optional<Refused> PickPolicy::refusal(const PickCandidate& candidate,
                                           const std::optional<PickBin>& bin,
                                           const PickPlan::Offer& offer,
                                           const std::optional<Refused>& barred) const {
  const auto refuse = [&](PickRefusal reason, const std::string& text) {
    return Refused{offer.candidate, reason, text};
  };
  if (candidate.withheld) return refuse(*candidate.withheld, candidate.withheld_text);
  const auto outside = bin ? outsideOf(*bin, candidate) : std::nullopt;
  if (outside) return refuse(PickRefusal::kOutside, *outside);
  if (!candidate.other_picks.empty()) {
    return refuse(
        PickRefusal::kNoPickPose,
        "none of its file's pick poses is for the face that is up: " + candidate.other_picks);
  }
  if (candidate.score < params_.score_min) {
    return refuse(PickRefusal::kLowScore,
                  format("score %.2f, at least %.2f", candidate.score, params_.score_min));
  }
  if (candidate.visible_fraction < params_.visible_min) {
    return refuse(PickRefusal::kOccluded, format("%.2f of it visible, at least %.2f",
                                                 candidate.visible_fraction, params_.visible_min));
  }
  if (barred && barred->reason == PickRefusal::kOccluded) return barred;
  if (candidate.tilt_deg > params_.tilt_max_deg) {
    return refuse(PickRefusal::kTilt, format("tilted by %.1f degrees, at most %.1f",
                                             candidate.tilt_deg, params_.tilt_max_deg));
  }
  if (const auto unsure = unsureOf(candidate, params_))
    return refuse(PickRefusal::kNeedsView, *unsure);
  if (offer.failures >= params_.failures_max) {
    return refuse(
        PickRefusal::kFailedBefore,
        format("%d picks or looks failed here, and the scene is as it was", offer.failures));
  }
  return barred;
}

PickPlan PickPolicy::plan(std::vector<PickCandidate> candidates, const std::optional<PickBin>& bin,
                          std::size_t max_parts) {
  PickPlan plan;
  const std::vector<double> visible = coverByOthers(&candidates);
  std::vector<PickPlace> places;
  std::vector<PickInstance> instances;
  bool as_given = true;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    places.push_back(placeOf(candidates[i], visible[i], bin));
    as_given = as_given && visible[i] == candidates[i].visible_fraction && visible[i] >= kFree;
    instances.push_back(instanceOf(candidates[i]));
  }
  for (const std::size_t i : failures_.moved(instances)) {
    places[i].rank *= kDragged;
    as_given = false;
  }
  for (const std::size_t i : ordered(places, params_.order, as_given)) {
    PickPlan::Offer offer{i, {}, failures_.recall(instances[i])};
    const auto barred = dropBarred(candidates, bin, &offer);
    const auto refused = refusal(candidates[i], bin, offer, barred);
    if (refused) {
      plan.refused.push_back(*refused);
    } else {
      plan.offers.push_back(std::move(offer));
    }
  }
  std::stable_sort(plan.offers.begin(), plan.offers.end(),
                   [](const auto& a, const auto& b) { return a.failures < b.failures; });
  std::sort(plan.refused.begin(), plan.refused.end(),
            [](const auto& a, const auto& b) { return a.candidate < b.candidate; });
  // The smaller of the two limits; zero is none.
  const auto most = static_cast<std::size_t>(params_.max_parts);
  if (most != 0 && (max_parts == 0 || most < max_parts)) max_parts = most;
  if (max_parts == 0) return plan;
  for (std::size_t rank = max_parts; rank < plan.offers.size(); ++rank) {
    plan.refused.push_back({plan.offers[rank].candidate, PickRefusal::kBeyondMaxParts,
                            format("its rank is %zu, max_parts is %zu", rank + 1, max_parts)});
  }
  plan.offers.resize(std::min(plan.offers.size(), max_parts));
  return plan;
}

void PickPolicy::fail(const PickCandidate& candidate) { failures_.add(instanceOf(candidate)); }

void PickPolicy::succeed(const PickCandidate& candidate) {
  failures_.remove(instanceOf(candidate));
}

double tiltSigma(const Matrix6d& covariance) {
  const double a = covariance(3, 3), b = covariance(4, 4), c = covariance(3, 4);
  return std::sqrt(std::max(0.0, 0.5 * (a + b) + std::hypot(0.5 * (a - b), c)));
}

std::string deadlockHint(const std::vector<Refused>& refused) {
  std::map<PickRefusal, int> counts;
  for (const Refused& part : refused) ++counts[part.reason];
  std::vector<std::pair<PickRefusal, int>> ordered(counts.begin(), counts.end());
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (const auto& [reason, count] : ordered) {
    text += (text.empty() ? "" : "; ") + format("%d of %zu ", count, refused.size()) +
            remedyFor(reason);
  }
  return text.empty() ? "nothing was found" : text;
}

}  // namespace planar_bin_picking
