// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// ~list_parts and ~reload_parts, and the parts' pictures.

#include "locator/parts/part_pictures.h"
#include "locator/parts/part_store.h"

#include <planar_bin_picking/ListParts.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

namespace planar_bin_picking_ros {

class PartServices {
 public:
  /// @param nh         its callback queue reads parts, which may take seconds
  /// @param prompt_nh  its callback queue lists them
  PartServices(PartStore& store, ros::NodeHandle nh, ros::NodeHandle prompt_nh);

 private:
  bool serveList(planar_bin_picking::ListParts::Request& request,
                 planar_bin_picking::ListParts::Response& response);
  bool serveReload(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  PartStore& store_;
  ros::ServiceServer list_, reload_;
  PartPictures pictures_;
};

}  // namespace planar_bin_picking_ros
