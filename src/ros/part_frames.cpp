// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part_frames.h"

#include "convert.h"
#include "names.h"

#include <algorithm>

namespace planar_bin_picking_ros {

using planar_bin_picking::LocatedPart;

namespace {

geometry_msgs::TransformStamped lost(const std::string& frame, const std_msgs::Header& header) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = header.stamp;
  transform.header.frame_id = kNotLocatedFrame;
  transform.child_frame_id = frame;
  transform.transform.rotation.w = 1.0;
  return transform;
}

}  // namespace

void PartFrames::name(std::vector<LocatedPart>& located) const {
  std::map<std::string, std::size_t> ranks;
  for (LocatedPart& part : located) part.child_frame = frame(part.part, ++ranks[part.part]);
}

std::vector<geometry_msgs::TransformStamped> PartFrames::update(
    const std::vector<std::string>& asked_for, const std_msgs::Header& header,
    const std::vector<LocatedPart>& located) {
  std::vector<geometry_msgs::TransformStamped> transforms;
  std::map<std::string, std::size_t> found;
  for (const LocatedPart& part : located) {
    geometry_msgs::TransformStamped transform;
    transform.header = header;
    transform.child_frame_id = part.child_frame;
    transform.transform = toTransformMsg(fromMsg(part.pose.pose));
    transforms.push_back(transform);
    ++found[part.part];
  }
  for (const std::string& part : asked_for) {
    for (std::size_t rank = found[part] + 1; rank <= sent_[part]; ++rank)
      transforms.push_back(lost(frame(part, rank), header));
    // Frames once sent stay known to tf2, so the largest number ever sent is what counts.
    sent_[part] = std::max(sent_[part], found[part]);
  }
  const auto picks = updatePicks(asked_for, header, located);
  transforms.insert(transforms.end(), picks.begin(), picks.end());
  return transforms;
}

std::vector<geometry_msgs::TransformStamped> PartFrames::updatePicks(
    const std::vector<std::string>& asked_for, const std_msgs::Header& header,
    const std::vector<LocatedPart>& located) {
  std::vector<geometry_msgs::TransformStamped> transforms;
  std::map<std::string, std::set<std::string>> found;
  for (const LocatedPart& part : located) {
    const Eigen::Isometry3d T_part_target = fromMsg(part.pose.pose).inverse();
    for (const auto& pick : part.picks) {
      geometry_msgs::TransformStamped transform;
      transform.header.stamp = header.stamp;
      transform.header.frame_id = part.child_frame;
      transform.child_frame_id = part.child_frame + "/" + pick.name;
      transform.transform = toTransformMsg(T_part_target * fromMsg(pick.pose));
      found[part.part].insert(transform.child_frame_id);
      transforms.push_back(transform);
    }
  }
  for (const std::string& part : asked_for) {
    std::set<std::string>& sent = sent_picks_[part];
    for (const std::string& frame : sent)
      if (found[part].count(frame) == 0) transforms.push_back(lost(frame, header));
    sent.insert(found[part].begin(), found[part].end());
  }
  return transforms;
}

}  // namespace planar_bin_picking_ros
