// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The parts' frames on tf: `<part>_1`, `<part>_2`, ... in rank order, and below each those of the
/// pick poses that the tool can reach: `<part>_1/<pick>`.
///
/// A part that lies in the bin stays where it was seen, and its frame is sent again and again, as
/// that of a robot is: whoever has died sends none, and a static transform would stay for ever with
/// those who listen. tf2 cannot forget a frame; one that is no longer offered is moved below a
/// parent that hangs on nothing (kNotLocatedFrame), so that a look-up fails instead of answering
/// with an old pose. That, too, is sent for a while, to those who missed it.

#include <geometry_msgs/TransformStamped.h>
#include <planar_bin_picking/LocatedPart.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

/// What tells the frames of one locator from another's, where its cell says nothing.
/// @param node  full name of the node
/// @return  nothing for /locator, its name and a slash for others: `left/locator/`
std::string defaultFramePrefix(const std::string& node);

class PartFrames {
 public:
  using Transforms = std::vector<geometry_msgs::TransformStamped>;

  explicit PartFrames(std::string prefix) : prefix_(std::move(prefix)) {}

  /// Names the frames of an answer, by rank within each part. Those that have a name keep it, and
  /// no frame that stands gets a second part.
  void name(std::vector<planar_bin_picking::LocatedPart>& located) const;

  /// From now on the frames of these parts are not located.
  /// @param parts  their names
  void withdraw(const std::vector<std::string>& parts);
  void withdrawAll();
  /// Likewise these frames and those of their pick poses.
  void withdrawLocated(const std::vector<std::string>& frames);
  /// Frames that a former process has sent.
  void withdrawFrames(const std::vector<std::string>& frames);

  /// From now on tf shows this answer.
  /// @param header  of the answer: stamp of the image, target frame
  /// @return  what to send at once, so that tf has the parts at the image's stamp, too
  Transforms show(const std_msgs::Header& header,
                  const std::vector<planar_bin_picking::LocatedPart>& located);

  /// What to send now; nothing at a time that was sent before, or while the clock stands at zero.
  Transforms at(const ros::Time& now);

  /// After the clock was set back, times that were sent before come again.
  void forgetTimes();

  /// All that were ever sent.
  std::vector<std::string> names() const;

 private:
  struct Sent {
    std::string part;                                      ///< "" where not known
    std::optional<geometry_msgs::TransformStamped> where;  ///< nothing: not located
    int repeats = 0;                                       ///< of the withdrawal, still to be sent
    ros::Time latest;                                      ///< sent
    ros::Time image;                                       ///< stamp of the latest answer
  };

  std::string frame(const std::string& part, std::size_t rank) const {
    return prefix_ + part + "_" + std::to_string(rank);
  }
  void withdraw(Sent* sent);
  void show(const std::string& part, const geometry_msgs::TransformStamped& transform,
            Transforms* out);

  std::string prefix_;
  std::map<std::string, Sent> frames_;
};

}  // namespace planar_bin_picking_ros
