// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/views/view_keeper.h"

#include "shared/refusal.h"

#include <planar_bin_picking/RefinePart.h>

#include <algorithm>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::Detection;
using planar_bin_picking::View;

namespace {

/// Each holds a picture or more.
constexpr std::size_t kAnswers = 6;

}  // namespace

void ViewKeeper::push(Kept kept) {
  const std::lock_guard<std::mutex> lock(mutex_);
  // A second answer to one image names its parts anew.
  kept_.remove_if([&](const Kept& other) { return other.header.stamp == kept.header.stamp; });
  kept_.push_front(std::move(kept));
  if (kept_.size() > kAnswers) kept_.pop_back();
}

void ViewKeeper::keep(const Answer& answer, const std::vector<Detection>& offered,
                      const std::vector<planar_bin_picking::LocatedPart>& located,
                      const std::vector<Detection>& needs_view,
                      const Eigen::Isometry3d& T_target_camera,
                      const std::optional<planar_bin_picking::ViewBin>& bin) {
  Kept kept{answer.header, {}, answer.frame, answer.grey};
  const auto add = [&](const Detection& detection, const std::string& child_frame) {
    kept.parts.push_back({child_frame,
                          answer.header.stamp,
                          answer.parts[detection.part],
                          {detection, {}},
                          T_target_camera,
                          answer.camera,
                          bin,
                          answer.frame.image->header.frame_id});
  };
  for (std::size_t i = 0; i < offered.size(); ++i) add(offered[i], located[i].child_frame);
  for (const Detection& detection : needs_view) add(detection, "");
  push(std::move(kept));
}

void ViewKeeper::keep(const std_msgs::Header& header, std::vector<KeptPart> parts) {
  push({header, std::move(parts), {}, {}});
}

std::vector<KeptPart> ViewKeeper::find(const ros::Time& stamp, const std::string& child_frame,
                                       std::size_t count) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto answer = std::find_if(kept_.begin(), kept_.end(),
                                   [&](const Kept& kept) { return kept.header.stamp == stamp; });
  const auto refuse = [](const std::string& text) {
    throw Refusal(planar_bin_picking::RefinePart::Response::UNKNOWN_PART,
                  text + "; give header.stamp and child_frame of a LocatedPart, or locate again");
  };
  if (answer == kept_.end()) refuse("no answer of that stamp is known any more");
  auto first = answer->parts.begin();
  if (!child_frame.empty()) {
    first = std::find_if(answer->parts.begin(), answer->parts.end(),
                         [&](const KeptPart& kept) { return kept.child_frame == child_frame; });
  }
  if (first == answer->parts.end())
    refuse("the answer of that stamp has no part '" + child_frame + "'");
  if (!answer->grey.empty()) {
    // The first look of all at this answer.
    const auto view = std::make_shared<const View>(answer->grey, answer->parts.front().camera,
                                                   Eigen::Isometry3d::Identity(), params_);
    for (KeptPart& kept : answer->parts) kept.tracked.views = {view};
    answer->grey.release();
    answer->frame = {};
  }
  const auto left = static_cast<std::size_t>(answer->parts.end() - first);
  return {first,
          first + static_cast<std::ptrdiff_t>(std::min(std::max<std::size_t>(1, count), left))};
}

}  // namespace planar_bin_picking_ros
