// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The locator's ROS parameters -> parameter structs.

#include "locator/settings/cell_params.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/pick/pick_policy.h"

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

namespace planar_bin_picking_ros {

/// @param tree  as readTree returns it
/// @throws std::invalid_argument  unknown key, wrong type or value out of range: key, value,
/// allowed
planar_bin_picking::LocatorParams loadLocatorParams(const XmlRpc::XmlRpcValue& tree);
CellParams loadCellParams(const XmlRpc::XmlRpcValue& tree);
planar_bin_picking::PickParams loadPickParams(const XmlRpc::XmlRpcValue& tree);

/// "key: value" of every field, one a line, for the log at start.
std::string describe(const planar_bin_picking::LocatorParams& params);
std::string describe(const CellParams& params);
std::string describe(const planar_bin_picking::PickParams& params);

}  // namespace planar_bin_picking_ros
