// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/param_reader.h"

namespace planar_bin_picking_ros {

XmlRpc::XmlRpcValue readTree(const ros::NodeHandle& pnh, const std::string& name) {
  XmlRpc::XmlRpcValue tree;
  if (!pnh.getParam(name, tree)) tree.begin();  // makes it an empty struct
  return tree;
}

}  // namespace planar_bin_picking_ros
