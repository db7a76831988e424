// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// tf2 as the package uses it: one transform at one moment, or the reason why there is none. Never
/// identity, never "the latest one", and nothing made up between two samples that are far apart:
/// tf2 interpolates over any gap, and a robot whose tf was silent may have been anywhere.

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <Eigen/Geometry>

#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace planar_bin_picking_ros {

/// s; what the nodes' parameters have where nothing else is said. A robot that publishes at 10 Hz
/// may lose one message; one that brakes with 1 m/s^2 is interpolated to 5 mm over it (a t^2 / 8).
constexpr double kTfGapMax = 0.2;

/// A tf2 buffer that also knows the moments of its samples, which tf2 itself does not tell. Any
/// number of threads.
class TransformBuffer : public tf2::BufferCore {
 public:
  /// @param gap_max  s, between the two samples around a stamp
  explicit TransformBuffer(double gap_max = kTfGapMax) : gap_max_(gap_max) {}

  /// As tf2's own. @return  false where tf2 does not take it
  bool setTransform(const geometry_msgs::TransformStamped& transform, const std::string& authority,
                    bool is_static = false);
  /// Forgets all but static transforms.
  void clear();

  /// @return  the words for a gap on the way from source to target at that stamp, if there is one
  std::optional<std::string> gapAt(const std::string& target, const std::string& source,
                                   const ros::Time& stamp) const;

 private:
  std::optional<std::string> gapOf(const std::string& frame, const ros::Time& stamp) const;

  const double gap_max_;
  mutable std::mutex mutex_;
  std::map<std::string, std::deque<ros::Time>> samples_;  ///< by child frame, ascending
};

struct LookupResult {
  std::optional<Eigen::Isometry3d> T_target_source;
  std::string reason;  ///< tf2's words or those of the gap, where there is no transform
};

/// @param stamp    the image's; the robot's tf may come in later than the image, hence
/// @param timeout  how long to wait for it, wall time (ROS time may stand still)
LookupResult lookup(const TransformBuffer& buffer, const std::string& target,
                    const std::string& source, const ros::Time& stamp,
                    std::chrono::duration<double> timeout);

}  // namespace planar_bin_picking_ros
