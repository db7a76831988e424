// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/pick_keeper.h"

#include "planar_bin_picking/image/grey.h"
#include "shared/convert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::Detection;
using planar_bin_picking::Face;
using planar_bin_picking::FaceFilter;
using planar_bin_picking::LocatedPart;
using planar_bin_picking::PartModel;
using planar_bin_picking::PickCandidate;
using planar_bin_picking::PickRefusal;
using planar_bin_picking::PickScene;
using planar_bin_picking::RefusedPart;
using planar_bin_picking::ReportPick;
using planar_bin_picking::Withheld;

namespace {

planar_bin_picking::PickFace faceOf(const PartModel& part, const Detection& detection,
                                    const Eigen::Isometry3d& T_target_camera) {
  planar_bin_picking::PickFace face;
  face.T_target_part = T_target_camera * detection.T_camera_part;
  face.up = detection.face;
  for (const int cell : detection.covered) face.covered.push_back(part.faceGrid().cells()[cell]);
  face.cell_size = part.faceGrid().cellSize();
  return face;
}

/// Of the face's normal against the bin's floor, or without a bin against the image plane.
double tiltDegrees(const Detection& detection, const PickKeeper::Frames& frames) {
  const Eigen::Vector3d normal_camera = detection.T_camera_part.linear().col(2);
  const double cosine =
      frames.bin
          ? (frames.bin->T_bin_target * frames.T_target_camera).linear().row(2).dot(normal_camera)
          : normal_camera.z();
  return std::acos(std::min(1.0, std::abs(cosine))) * 180.0 / M_PI;
}

/// Which pick poses the part's file has, where it has some and the located part has none.
std::string otherPicks(const PartModel& part, const LocatedPart& located) {
  std::string text;
  if (!located.picks.empty()) return text;
  for (const auto& pick : part.file().pick_poses) {
    const bool front = pick.face == FaceFilter::kFront;
    text += (text.empty() ? "" : ", ") + pick.name + (front ? " (front)" : " (back)");
  }
  return text;
}

/// Away from the bin's floor, or from what the answers' frame stands on; toward the camera where
/// that is its own.
Eigen::Vector3d upOf(const PickKeeper::Frames& frames) {
  if (frames.bin) return frames.bin->T_bin_target.linear().row(2);
  const bool is_camera = frames.T_target_camera.matrix() == Eigen::Matrix4d::Identity();
  return Eigen::Vector3d(0.0, 0.0, is_camera ? -1.0 : 1.0);
}

/// The ways to and from the pick poses.
void addWays(const PartModel& part, const Eigen::Vector3d& up_target, LocatedPart* located) {
  const auto& robot = part.file().robot;
  for (auto& pick : located->picks) {
    const Eigen::Isometry3d T_target_pick = fromMsg(pick.pose);
    pick.approach =
        toPoseMsg(T_target_pick * Eigen::Translation3d(0.0, 0.0, -robot.approach.value_or(0.0)));
    pick.retreat =
        toPoseMsg(Eigen::Translation3d(up_target * robot.retreat.value_or(0.0)) * T_target_pick);
  }
}

/// One detection, what of it is answered, and what the policy judges it by.
struct Entry {
  Detection detection;
  LocatedPart located;
  PickCandidate candidate;
};

Entry entryOf(const Answer& answer, const PickScene& scene, const Detection& detection,
              const PickKeeper::Frames& frames) {
  const PartModel& part = *answer.parts[detection.part];
  const Eigen::Vector3d center(part.center().x(), part.center().y(), part.faceZ(detection.face));
  Entry entry{detection, toMsg(detection, part, frames.T_target_camera), {}};
  LocatedPart& located = entry.located;
  PickCandidate& candidate = entry.candidate;
  located.header = answer.header;
  addWays(part, upOf(frames), &located);
  candidate.part = located.part;
  candidate.model = answer.parts[detection.part];
  candidate.face = faceOf(part, detection, frames.T_target_camera);
  candidate.center = candidate.face.T_target_part * center;
  const Eigen::Matrix3d R_target_part = candidate.face.T_target_part.linear();
  candidate.center_covariance =
      R_target_part * detection.covariance.topLeftCorner<3, 3>() * R_target_part.transpose();
  candidate.score = located.score;
  candidate.confirmed = detection.evidence.edges;
  candidate.visible_fraction = located.visible_fraction;
  candidate.tilt_deg = tiltDegrees(detection, frames);
  for (const auto& pick : located.picks) candidate.T_target_pick.push_back(fromMsg(pick.pose));
  candidate.other_picks = otherPicks(part, located);
  candidate.tool = part.file().tool;
  candidate.approach = part.file().robot.approach.value_or(0.0);
  const Eigen::Vector3d ray = (detection.T_camera_part * center).normalized();
  const Eigen::Matrix3d R_camera_part = detection.T_camera_part.linear();
  const Eigen::Matrix3d place =
      R_camera_part * detection.covariance.topLeftCorner<3, 3>() * R_camera_part.transpose();
  candidate.depth_sigma = std::sqrt(std::max(0.0, ray.dot(place * ray)));
  candidate.tilt_sigma = planar_bin_picking::tiltSigma(detection.covariance);
  constexpr double kAround = 1.2;  // radii
  const Eigen::Isometry3d T_scene_part =
      answer.first ? answer.first->T_this_now * detection.T_camera_part : detection.T_camera_part;
  candidate.surroundings =
      planar_bin_picking::cutSurroundings(scene, T_scene_part, center, kAround * part.radius());
  return entry;
}

/// All that was found; what the locator itself withheld says so.
std::vector<Entry> entriesOf(const Answer& answer, const PickKeeper::Frames& frames) {
  const cv::Mat& grey = answer.first ? answer.first->grey : answer.grey;
  const PickScene scene{grey, planar_bin_picking::bitsInUse(grey),
                        answer.first ? answer.first->camera : answer.camera};
  std::vector<Entry> entries;
  for (const Detection& detection : answer.result.detections)
    entries.push_back(entryOf(answer, scene, detection, frames));
  for (const auto& withheld : answer.result.withheld) {
    entries.push_back(entryOf(answer, scene, withheld.detection, frames));
    entries.back().candidate.withheld =
        withheld.reason == Withheld::kOutside     ? PickRefusal::kOutside
        : withheld.reason == Withheld::kWrongFace ? PickRefusal::kWrongFace
                                                  : PickRefusal::kContradicted;
    entries.back().candidate.withheld_text = withheld.text;
  }
  return entries;
}

/// For each pick pose, what lies below the tool that none of the parts explains.
void addStrangeEdges(const Answer& answer, const std::vector<planar_bin_picking::ToolBody>& bodies,
                     const PickKeeper::Frames& frames, std::vector<Entry>* entries) {
  if (bodies.empty()) return;
  std::vector<planar_bin_picking::StrangeEdges::Seen> seen;
  for (const Entry& entry : *entries)
    seen.push_back({entry.candidate.model, entry.detection.T_camera_part});
  const planar_bin_picking::StrangeEdges strange(answer.grey, answer.camera, seen);
  for (Entry& entry : *entries) {
    for (const auto& T_target_pick : entry.candidate.T_target_pick) {
      entry.candidate.strange_edges.push_back(
          strange.below(bodies, frames.T_target_camera.inverse() * T_target_pick));
    }
  }
}

std::uint8_t reasonOf(const PickRefusal reason) {
  switch (reason) {
    case PickRefusal::kLowScore:
      return RefusedPart::LOW_SCORE;
    case PickRefusal::kOccluded:
      return RefusedPart::OCCLUDED;
    case PickRefusal::kTilt:
      return RefusedPart::TILT;
    case PickRefusal::kWall:
      return RefusedPart::WALL;
    case PickRefusal::kNoRoom:
      return RefusedPart::NO_ROOM;
    case PickRefusal::kFailedBefore:
      return RefusedPart::FAILED_BEFORE;
    case PickRefusal::kOutside:
      return RefusedPart::OUTSIDE;
    case PickRefusal::kNoPickPose:
      return RefusedPart::NO_PICK_POSE;
    case PickRefusal::kWrongFace:
      return RefusedPart::WRONG_FACE;
    case PickRefusal::kNeedsView:
      return RefusedPart::NEEDS_VIEW;
    case PickRefusal::kContradicted:
      return RefusedPart::CONTRADICTED;
    case PickRefusal::kBeyondMaxParts:
      break;
  }
  return RefusedPart::BEYOND_MAX_PARTS;
}

}  // namespace

std::vector<planar_bin_picking::ToolBody> PickKeeper::bodiesOf(const Call& call) const {
  if (call.params)
    return planar_bin_picking::toolBodies(call.params->tool_boxes, call.params->tool_cylinders);
  const std::lock_guard<std::mutex> lock(mutex_);
  return policy_.bodies();
}

PickKeeper::Offered PickKeeper::offer(Answer answer, const Frames& frames, const Call& call,
                                      const Publish& publish) {
  std::vector<Entry> entries = entriesOf(answer, frames);
  addStrangeEdges(answer, bodiesOf(call), frames, &entries);
  std::vector<PickCandidate> candidates;
  for (const Entry& entry : entries) candidates.push_back(entry.candidate);

  const std::lock_guard<std::mutex> lock(mutex_);
  if (call.params) policy_.use(*call.params);
  const auto plan = policy_.plan(candidates, frames.bin, call.max_parts);
  Offered offered;
  offered.hint = planar_bin_picking::deadlockHint(plan.refused);
  for (const auto& entry : plan.refused) {
    RefusedPart refused;
    refused.reason = reasonOf(entry.reason);
    refused.text = entry.text;
    refused.located = entries[entry.candidate].located;
    offered.refused.push_back(refused);
    answer.refused_detections.push_back(entries[entry.candidate].detection);
    if (entry.reason == PickRefusal::kNeedsView)
      offered.needs_view.push_back(entries[entry.candidate].detection);
  }
  answer.refused = offered.refused;
  answer.T_target_camera = frames.T_target_camera;
  answer.tool_radius = policy_.params().tool_radius;
  answer.tool_bodies = policy_.bodies();
  answer.located.clear();
  answer.result.detections.clear();
  for (const auto& offer : plan.offers) {
    const Entry& entry = entries[offer.candidate];
    answer.located.push_back(entry.located);
    answer.located.back().picks.clear();
    if (answer.former)
      answer.located.back().child_frame = answer.former->at(entry.detection.part).child_frame;
    for (const std::size_t k : offer.picks)
      answer.located.back().picks.push_back(entry.located.picks[k]);
    answer.result.detections.push_back(entry.detection);
    offered.detections.push_back(entry.detection);
  }
  Open open{call.caller, answer.frame.received, {}};
  const std::vector<planar_bin_picking::PartPtr> asked_for = answer.parts;
  const auto former = answer.former;
  offered.parts = publish(std::move(answer));
  for (std::size_t i = 0; i < offered.parts.size(); ++i)
    open.parts.push_back({offered.parts[i], candidates[plan.offers[i].candidate]});
  if (former)
    replace(std::move(open), *former);
  else
    keep(std::move(open), asked_for);
  return offered;
}

void PickKeeper::keep(Open answer, const std::vector<planar_bin_picking::PartPtr>& asked_for) {
  // Callers without a fixed name, such as rosservice, would pile up answers for ever.
  constexpr std::size_t kAnswers = 100;
  for (Open& older : open_) {
    if (older.caller != answer.caller) continue;
    const auto is_asked_again = [&](const Kept& kept) {
      return std::any_of(asked_for.begin(), asked_for.end(),
                         [&](const auto& part) { return part->name() == kept.located.part; });
    };
    older.parts.erase(std::remove_if(older.parts.begin(), older.parts.end(), is_asked_again),
                      older.parts.end());
  }
  open_.push_front(std::move(answer));
  open_.remove_if([](const Open& open) { return open.parts.empty(); });
  if (open_.size() > kAnswers) open_.pop_back();
}

void PickKeeper::replace(Open answer, const std::vector<FormerPart>& former) {
  const auto formerOf = [&former](const Kept& kept) {
    return std::find_if(former.begin(), former.end(), [&](const FormerPart& part) {
      return part.child_frame == kept.located.child_frame &&
             part.stamp == kept.located.header.stamp;
    });
  };
  const auto was = [&](const Kept& kept) { return formerOf(kept) != former.end(); };
  // Found there again, it comes last: or the program would look at it twice for ever.
  for (const Open& older : open_) {
    for (const Kept& kept : older.parts)
      if (was(kept) && formerOf(kept)->gone) policy_.fail(kept.candidate);
  }
  for (Open& older : open_) {
    if (older.caller != answer.caller || std::none_of(older.parts.begin(), older.parts.end(), was))
      continue;
    older.parts.erase(std::remove_if(older.parts.begin(), older.parts.end(), was),
                      older.parts.end());
    // A pick since the older image makes all of it old, which sends the program to locate again.
    older.parts.insert(older.parts.begin(), answer.parts.begin(), answer.parts.end());
    answer.parts.clear();
  }
  keep(std::move(answer), {});
}

std::optional<PickKeeper::Found> PickKeeper::find(const std::string& caller,
                                                  const ReportPick::Request& request) {
  std::optional<Found> found;
  for (auto answer = open_.begin(); answer != open_.end(); ++answer) {
    const bool is_own = answer->caller == caller;
    if (found && !is_own) continue;  // its own comes first, then the latest
    const auto part =
        std::find_if(answer->parts.begin(), answer->parts.end(), [&](const Kept& kept) {
          return kept.located.child_frame == request.child_frame &&
                 kept.located.header.stamp == request.stamp;
        });
    if (part == answer->parts.end()) continue;
    found = Found{answer, part};
    if (is_own) break;
  }
  return found;
}

void PickKeeper::report(const std::string& caller, const ReportPick::Request& request,
                        ReportPick::Response* response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = find(caller, request);
  if (!found) {
    response->status = ReportPick::Response::UNKNOWN_PART;
    response->message = "no answer that still holds has a part '" + request.child_frame +
                        "' of that stamp that was not reported yet; report child_frame and "
                        "header.stamp of the LocatedPart, before you ask for that part again";
    return;
  }
  response->status = ReportPick::Response::LOCATE;
  const auto [answer, part] = *found;
  if (request.success) {
    policy_.succeed(part->candidate);
    scene_changed_ = std::chrono::steady_clock::now();
    open_.erase(answer);
    response->message = "picked; the scene has changed: locate again";
    return;
  }
  policy_.fail(part->candidate);
  const bool is_old = answer->received < scene_changed_;
  answer->parts.erase(part);
  if (!answer->parts.empty() && !is_old) {
    response->status = ReportPick::Response::NEXT;
    response->next = answer->parts.front().located;
    response->message = "failed; next in rank: " + response->next.child_frame;
    return;
  }
  response->message = is_old ? "failed, and the scene has changed since the image: locate again"
                             : "failed, and nothing else was offered: locate again";
  if (answer->parts.empty()) open_.erase(answer);
}

}  // namespace planar_bin_picking_ros
