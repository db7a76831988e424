// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hdr/hdr_ros.h"

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include <memory>

namespace planar_bin_picking_ros {

class HdrNodelet : public nodelet::Nodelet {
  void onInit() override {
    try {
      hdr_ = std::make_unique<HdrRos>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM(error.what());
      throw;
    }
  }

  std::unique_ptr<HdrRos> hdr_;
};

}  // namespace planar_bin_picking_ros

PLUGINLIB_EXPORT_CLASS(planar_bin_picking_ros::HdrNodelet, nodelet::Nodelet)
