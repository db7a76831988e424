// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Publishes what stands about the parts on the latched topic ~scene. Any number of threads.

#include "locator/answer/scene_markers.h"

#include <ros/node_handle.h>

#include <map>
#include <mutex>
#include <string>

namespace planar_bin_picking_ros {

class ScenePublisher {
 public:
  explicit ScenePublisher(const ros::NodeHandle& pnh);

  /// From now on this is what is shown of `thing`; without markers, nothing of it.
  void show(const std::string& thing, Markers markers);

 private:
  std::mutex mutex_;
  std::map<std::string, Markers> shown_;
  ros::Publisher topic_;
};

}  // namespace planar_bin_picking_ros
