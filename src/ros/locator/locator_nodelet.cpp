// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/locator_ros.h"

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include <memory>

namespace planar_bin_picking_ros {

class LocatorNodelet : public nodelet::Nodelet {
  void onInit() override {
    try {
      locator_ = std::make_unique<LocatorRos>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM(error.what());
      throw;
    }
  }

  std::unique_ptr<LocatorRos> locator_;
};

}  // namespace planar_bin_picking_ros

PLUGINLIB_EXPORT_CLASS(planar_bin_picking_ros::LocatorNodelet, nodelet::Nodelet)
