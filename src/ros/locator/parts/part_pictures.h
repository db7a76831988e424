// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A picture of each part, as a topic of its own, for rviz: `~part_pictures/<part>`. It is drawn
/// for those who look at it and anew when the part changes; five hundred parts that nobody looks at
/// cost nothing.

#include "locator/parts/part_store.h"

#include <ros/node_handle.h>

#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace planar_bin_picking_ros {

class PartPictures {
 public:
  /// @param nh  its callback queue draws, some 10 ms a picture
  PartPictures(PartStore& store, const ros::NodeHandle& nh);

 private:
  struct Topic {
    ros::Publisher publisher;
    PartPtr part;
  };

  /// Topics come and go with the parts.
  void look();

  PartStore& store_;
  ros::NodeHandle nh_;
  std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<const PartLibrary> seen_;
  std::map<std::string, Topic> topics_;
  ros::WallTimer timer_;
};

/// The part's topic, below the node's name. What no name of ROS can hold is written as _x and its
/// number: "lever-2" is "part_pictures/lever_x2d2".
std::string pictureTopic(const std::string& part);

}  // namespace planar_bin_picking_ros
