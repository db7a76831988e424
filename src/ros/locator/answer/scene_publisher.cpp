// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/scene_publisher.h"

#include "shared/names.h"

#include <visualization_msgs/MarkerArray.h>

#include <utility>

namespace planar_bin_picking_ros {

ScenePublisher::ScenePublisher(const ros::NodeHandle& pnh) {
  constexpr bool kLatch = true;
  topic_ = ros::NodeHandle(pnh).advertise<visualization_msgs::MarkerArray>(kSceneTopic, 1, kLatch);
}

void ScenePublisher::show(const std::string& thing, Markers markers) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (markers.empty() && shown_.count(thing) == 0) return;
  shown_[thing] = std::move(markers);
  visualization_msgs::MarkerArray array;
  array.markers.emplace_back();
  array.markers.back().action = visualization_msgs::Marker::DELETEALL;
  for (const auto& [name, of_it] : shown_)
    array.markers.insert(array.markers.end(), of_it.begin(), of_it.end());
  topic_.publish(array);
}

}  // namespace planar_bin_picking_ros
