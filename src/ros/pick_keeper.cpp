// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pick_keeper.h"

#include "convert.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking_ros {

using planar_bin_picking::Detection;
using planar_bin_picking::LocatedPart;
using planar_bin_picking::PartModel;
using planar_bin_picking::PickCandidate;
using planar_bin_picking::PickRefusal;
using planar_bin_picking::RefusedPart;
using planar_bin_picking::ReportPick;

namespace {

planar_bin_picking::PickFace faceOf(const PartModel& part, const Detection& detection,
                                    const Eigen::Isometry3d& T_target_camera) {
  planar_bin_picking::PickFace face;
  face.T_target_part = T_target_camera * detection.T_camera_part;
  for (const int cell : detection.covered) face.covered.push_back(part.faceGrid().cells()[cell]);
  face.cell_size = part.faceGrid().cellSize();
  return face;
}

PickCandidate candidateOf(const Answer& answer, const std::size_t i,
                          const PickKeeper::Frames& frames) {
  const Detection& detection = answer.result.detections[i];
  const LocatedPart& located = answer.located[i];
  const PartModel& part = *answer.parts[detection.part];
  const Eigen::Vector3d center(part.center().x(), part.center().y(), part.faceZ(detection.face));
  PickCandidate candidate;
  candidate.part = located.part;
  candidate.center = frames.T_target_camera * (detection.T_camera_part * center);
  candidate.score = located.score;
  candidate.visible_fraction = located.visible_fraction;
  // The face's normal against the bin's z, or against the camera's axis.
  const Eigen::Vector3d normal_camera = detection.T_camera_part.linear().col(2);
  const double cosine =
      frames.bin
          ? (frames.bin->T_bin_target * frames.T_target_camera).linear().row(2).dot(normal_camera)
          : normal_camera.z();
  candidate.tilt_deg = std::acos(std::min(1.0, std::abs(cosine))) * 180.0 / M_PI;
  for (const auto& pick : located.picks) candidate.T_target_pick.push_back(fromMsg(pick.pose));
  candidate.tool = part.file().tool;
  candidate.face = faceOf(part, detection, frames.T_target_camera);
  constexpr double kAround = 1.2;  // radii
  candidate.surroundings = planar_bin_picking::cutSurroundings(
      answer.grey, answer.camera, detection.T_camera_part, center, kAround * part.radius());
  return candidate;
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
    case PickRefusal::kFailedBefore:
      break;
  }
  return RefusedPart::FAILED_BEFORE;
}

}  // namespace

PickKeeper::Sorted PickKeeper::sort(Answer* answer, const Frames& frames) {
  std::vector<PickCandidate> candidates;
  for (std::size_t i = 0; i < answer->located.size(); ++i)
    candidates.push_back(candidateOf(*answer, i, frames));

  const std::lock_guard<std::mutex> lock(mutex_);
  const auto plan = policy_.plan(candidates, frames.bin);
  Sorted sorted;
  sorted.hint = planar_bin_picking::deadlockHint(plan.refused);
  for (const auto& entry : plan.refused) {
    RefusedPart refused;
    refused.reason = reasonOf(entry.reason);
    refused.text = entry.text;
    refused.located = answer->located[entry.candidate];
    sorted.refused.push_back(refused);
  }
  std::vector<LocatedPart> located;
  std::vector<Detection> detections;
  for (const auto& offer : plan.offers) {
    LocatedPart part = answer->located[offer.candidate];
    part.picks.clear();
    for (const std::size_t k : offer.picks)
      part.picks.push_back(answer->located[offer.candidate].picks[k]);
    located.push_back(part);
    detections.push_back(answer->result.detections[offer.candidate]);
    sorted.offered.push_back(candidates[offer.candidate]);
  }
  answer->located = std::move(located);
  answer->result.detections = std::move(detections);
  return sorted;
}

void PickKeeper::keep(const std::vector<LocatedPart>& located,
                      const std::vector<PickCandidate>& offered) {
  const std::lock_guard<std::mutex> lock(mutex_);
  offered_.clear();
  for (std::size_t i = 0; i < located.size(); ++i) offered_.push_back({located[i], offered.at(i)});
}

void PickKeeper::report(const ReportPick::Request& request, ReportPick::Response* response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto part = std::find_if(offered_.begin(), offered_.end(), [&](const Offered& offered) {
    return offered.located.child_frame == request.child_frame &&
           offered.located.header.stamp == request.stamp;
  });
  if (part == offered_.end()) {
    response->status = ReportPick::Response::UNKNOWN_PART;
    response->message = "the latest answer has no part '" + request.child_frame +
                        "' of that stamp that was not reported yet; report child_frame and "
                        "header.stamp of the LocatedPart";
    return;
  }
  response->status = ReportPick::Response::LOCATE;
  if (request.success) {
    policy_.succeed(part->candidate);
    offered_.clear();
    response->message = "picked; the scene has changed: locate again";
    return;
  }
  policy_.fail(part->candidate);
  offered_.erase(part);
  if (offered_.empty()) {
    response->message = "failed, and nothing else was offered: locate again";
    return;
  }
  response->status = ReportPick::Response::NEXT;
  response->next = offered_.front().located;
  response->message = "failed; next in rank: " + response->next.child_frame;
}

}  // namespace planar_bin_picking_ros
