// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The parts' frames on tf: `<part>_1`, `<part>_2`, ... in rank order, and below each those of the
/// pick poses that the tool can reach: `<part>_1/<pick>`.
///
/// They are static transforms: a part that lies in the bin stays where it was seen, also long after
/// the camera has moved on. What a later image no longer shows must not linger, though, and tf2
/// cannot forget a frame; such frames are moved below a parent that hangs on nothing
/// (kNotLocatedFrame), so that a look-up fails instead of answering with an old pose.

#include <geometry_msgs/TransformStamped.h>
#include <planar_bin_picking/LocatedPart.h>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

class PartFrames {
 public:
  explicit PartFrames(std::string prefix) : prefix_(std::move(prefix)) {}

  /// Names the frames of an answer, by rank within each part.
  void name(std::vector<planar_bin_picking::LocatedPart>& located) const;

  /// What to send so that tf shows this answer.
  /// @param asked_for  names of the parts that the call was about: only their frames are touched
  /// @param header     of the answer: stamp of the image, target frame
  std::vector<geometry_msgs::TransformStamped> update(
      const std::vector<std::string>& asked_for, const std_msgs::Header& header,
      const std::vector<planar_bin_picking::LocatedPart>& located);

 private:
  std::string frame(const std::string& part, std::size_t rank) const {
    return prefix_ + part + "_" + std::to_string(rank);
  }

  std::vector<geometry_msgs::TransformStamped> updatePicks(
      const std::vector<std::string>& asked_for, const std_msgs::Header& header,
      const std::vector<planar_bin_picking::LocatedPart>& located);

  std::string prefix_;
  std::map<std::string, std::size_t> sent_;  ///< part -> how many frames it has on tf
  std::map<std::string, std::set<std::string>> sent_picks_;  ///< part -> its picks' frames on tf
};

}  // namespace planar_bin_picking_ros
