// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/transforms.h"

#include "shared/convert.h"

#include <tf2/exceptions.h>

#include <algorithm>
#include <cstdio>
#include <thread>
#include <vector>

namespace planar_bin_picking_ros {

namespace {

/// tf2 ends its messages with a stop and a space, and ours go on after it.
std::string trimmed(std::string message) {
  message.erase(message.find_last_not_of(". ") + 1);
  return message;
}

/// tf2 knows frames without the slash that drivers of tf's first version put in front of them.
std::string tf2Name(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

/// The frame and all that it hangs on, at that moment, outward.
std::vector<std::string> wayUp(const tf2::BufferCore& buffer, const std::string& frame,
                               const ros::Time& stamp) {
  constexpr std::size_t kDeepest = 1000;  // tf2's own limit; a loop ends here, too
  std::vector<std::string> frames = {frame};
  std::string parent;
  while (frames.size() < kDeepest && buffer._getParent(frames.back(), stamp, parent))
    frames.push_back(parent);
  return frames;
}

}  // namespace

bool TransformBuffer::setTransform(const geometry_msgs::TransformStamped& transform,
                                   const std::string& authority, const bool is_static) {
  if (!tf2::BufferCore::setTransform(transform, authority, is_static)) return false;
  if (is_static) return true;
  const std::lock_guard<std::mutex> lock(mutex_);
  std::deque<ros::Time>& stamps = samples_[tf2Name(transform.child_frame_id)];
  const ros::Time stamp = transform.header.stamp;
  stamps.insert(std::upper_bound(stamps.begin(), stamps.end(), stamp), stamp);
  const ros::Duration kept(tf2::BufferCore::DEFAULT_CACHE_TIME);
  while (stamps.back() - stamps.front() > kept) stamps.pop_front();
  return true;
}

void TransformBuffer::clear() {
  tf2::BufferCore::clear();
  const std::lock_guard<std::mutex> lock(mutex_);
  samples_.clear();
}

std::optional<std::string> TransformBuffer::gapOf(const std::string& frame,
                                                  const ros::Time& stamp) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = samples_.find(frame);
  if (found == samples_.end()) return std::nullopt;  // static
  const auto& stamps = found->second;
  const auto after = std::lower_bound(stamps.begin(), stamps.end(), stamp);
  if (after == stamps.begin() || after == stamps.end() || *after == stamp) return std::nullopt;
  const auto before = std::prev(after);
  const double gap = (*after - *before).toSec();
  if (gap <= gap_max_) return std::nullopt;
  char text[300];
  std::snprintf(text, sizeof text,
                "tf says nothing of %s from %.3f s before the stamp to %.3f s after it, a gap of "
                "%.3f s where tf_gap_max allows %.3f s, and the frame may have moved in between; "
                "let its tf come without pauses, or allow a longer gap",
                frame.c_str(), (stamp - *before).toSec(), (*after - stamp).toSec(), gap, gap_max_);
  return text;
}

std::optional<std::string> TransformBuffer::gapAt(const std::string& target,
                                                  const std::string& source,
                                                  const ros::Time& stamp) const {
  std::vector<std::string> from_source = wayUp(*this, source, stamp);
  std::vector<std::string> from_target = wayUp(*this, target, stamp);
  // What both hang on alike is not on the way.
  while (!from_source.empty() && !from_target.empty() && from_source.back() == from_target.back()) {
    from_source.pop_back();
    from_target.pop_back();
  }
  from_source.insert(from_source.end(), from_target.begin(), from_target.end());
  for (const std::string& frame : from_source)
    if (const auto gap = gapOf(frame, stamp)) return gap;
  return std::nullopt;
}

LookupResult lookup(const TransformBuffer& buffer, const std::string& target,
                    const std::string& source, const ros::Time& stamp,
                    const std::chrono::duration<double> timeout) {
  // To tf2 a zero stamp means "the latest", which is what must never be answered.
  if (stamp.isZero()) return {std::nullopt, "the image has no stamp"};
  // tf2_ros::Buffer's own time-out counts ROS time and would never end while a bag is paused.
  constexpr std::chrono::milliseconds kPeriod(5);
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (true) {
    std::string reason;
    try {
      const auto found = buffer.lookupTransform(target, source, stamp);
      const auto gap = buffer.gapAt(target, source, stamp);
      if (!gap) return {fromMsg(found.transform), ""};
      reason = *gap;  // a sample that comes in late may still fill it
    } catch (const tf2::TransformException& error) {
      reason = trimmed(error.what());
    }
    if (std::chrono::steady_clock::now() >= deadline) return {std::nullopt, reason};
    std::this_thread::sleep_for(kPeriod);
  }
}

}  // namespace planar_bin_picking_ros
