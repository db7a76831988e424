// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/part_frames.h"

#include "shared/convert.h"
#include "shared/names.h"

#include <algorithm>
#include <set>

namespace planar_bin_picking_ros {

using geometry_msgs::TransformStamped;
using planar_bin_picking::LocatedPart;

namespace {

/// Ten seconds at kFrameRate: a listener that connects to a node that has just started takes one.
constexpr int kWithdrawals = static_cast<int>(10 * kFrameRate);

TransformStamped lost(const std::string& frame, const ros::Time& stamp) {
  TransformStamped transform;
  transform.header.stamp = stamp;
  transform.header.frame_id = kNotLocatedFrame;
  transform.child_frame_id = frame;
  transform.transform.rotation.w = 1.0;
  return transform;
}

/// Those of the part and of its pick poses.
std::vector<TransformStamped> transformsOf(const std_msgs::Header& header,
                                           const LocatedPart& part) {
  std::vector<TransformStamped> transforms(1);
  transforms[0].header = header;
  transforms[0].child_frame_id = part.child_frame;
  transforms[0].transform = toTransformMsg(fromMsg(part.pose.pose));
  const Eigen::Isometry3d T_part_target = fromMsg(part.pose.pose).inverse();
  for (const auto& pick : part.picks) {
    TransformStamped transform;
    transform.header.stamp = header.stamp;
    transform.header.frame_id = part.child_frame;
    transform.child_frame_id = part.child_frame + "/" + pick.name;
    transform.transform = toTransformMsg(T_part_target * fromMsg(pick.pose));
    transforms.push_back(transform);
  }
  return transforms;
}

}  // namespace

std::string defaultFramePrefix(const std::string& node) {
  if (node == "/locator") return "";
  return node.substr(node.find_first_not_of('/')) + "/";
}

void PartFrames::name(std::vector<LocatedPart>& located) const {
  std::set<std::string> taken;
  for (const LocatedPart& part : located) taken.insert(part.child_frame);
  for (const auto& [name, sent] : frames_)
    if (sent.where) taken.insert(name);
  std::map<std::string, std::size_t> ranks;
  for (LocatedPart& part : located) {
    if (!part.child_frame.empty()) continue;
    std::size_t& rank = ranks[part.part];
    do part.child_frame = frame(part.part, ++rank);
    while (taken.count(part.child_frame) > 0);
  }
}

void PartFrames::withdraw(Sent* sent) {
  if (sent->where) sent->repeats = kWithdrawals;
  sent->where.reset();
}

void PartFrames::withdraw(const std::vector<std::string>& parts) {
  for (auto& [name, sent] : frames_)
    if (std::find(parts.begin(), parts.end(), sent.part) != parts.end()) withdraw(&sent);
}

void PartFrames::withdrawAll() {
  for (auto& entry : frames_) withdraw(&entry.second);
}

void PartFrames::withdrawLocated(const std::vector<std::string>& frames) {
  for (auto& [name, sent] : frames_) {
    const std::string located = name.substr(0, name.find('/', prefix_.size()));
    if (std::find(frames.begin(), frames.end(), located) != frames.end()) withdraw(&sent);
  }
}

void PartFrames::withdrawFrames(const std::vector<std::string>& frames) {
  for (const std::string& frame : frames) frames_[frame].repeats = kWithdrawals;
}

PartFrames::Transforms PartFrames::show(const std_msgs::Header& header,
                                        const std::vector<LocatedPart>& located) {
  Transforms out;
  for (const LocatedPart& part : located)
    for (const auto& transform : transformsOf(header, part)) show(part.part, transform, &out);
  return out;
}

void PartFrames::show(const std::string& part, const TransformStamped& transform, Transforms* out) {
  Sent& sent = frames_[transform.child_frame_id];
  const ros::Time stamp = transform.header.stamp;
  sent.part = part;
  sent.where = transform;
  if (sent.image == stamp) return;  // a second answer to one image; tf2 keeps the first
  sent.image = stamp;
  // What was sent before and after that moment was another answer's: tf2 must not draw a line to
  // it.
  const ros::Duration beside(0, 10000);  // 10 us; Python's tf2 keeps times to a quarter of one
  if (!sent.latest.isZero()) out->push_back(lost(transform.child_frame_id, stamp - beside));
  out->push_back(transform);
  if (stamp < sent.latest) out->push_back(lost(transform.child_frame_id, stamp + beside));
  sent.latest = std::max(sent.latest, stamp);
}

PartFrames::Transforms PartFrames::at(const ros::Time& now) {
  Transforms out;
  if (now.isZero()) return out;  // to tf2 that means "whenever"
  for (auto& [frame, sent] : frames_) {
    if (now <= sent.latest || (!sent.where && sent.repeats == 0)) continue;
    out.push_back(sent.where ? *sent.where : lost(frame, now));
    out.back().header.stamp = now;
    sent.latest = now;
    if (!sent.where) --sent.repeats;
  }
  return out;
}

void PartFrames::forgetTimes() {
  for (auto& entry : frames_) entry.second.latest = entry.second.image = ros::Time();
}

std::vector<std::string> PartFrames::names() const {
  std::vector<std::string> names;
  for (const auto& entry : frames_) names.push_back(entry.first);
  return names;
}

}  // namespace planar_bin_picking_ros
