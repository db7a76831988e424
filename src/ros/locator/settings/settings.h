// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// All parameters of a locator together, by name: what is loaded at start, and what may be changed
/// while it runs. A call takes them as they are when it comes in and keeps to them.

#include "locator/settings/cell_params.h"
#include "locator/settings/yaml_edit.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/pick/pick_policy.h"

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <map>
#include <string>

namespace planar_bin_picking_ros {

struct Settings {
  planar_bin_picking::LocatorParams locator;
  CellParams cell;
  planar_bin_picking::PickParams pick;
};

/// The trees of parameters of these names, as readTree returns them. The cell's own `locator` and
/// `pick` win over the other two, so that what is special about a cell stands in one file.
/// @throws std::invalid_argument  unknown key, wrong type or value: key, value, allowed
Settings loadSettings(const XmlRpc::XmlRpcValue& locator, const XmlRpc::XmlRpcValue& pick,
                      const XmlRpc::XmlRpcValue& cell);
Settings loadSettings(const ros::NodeHandle& pnh);

/// Key: value of all of them, one a line.
std::string describe(const Settings& settings);

/// One number among the settings.
struct Number {
  double value = 0.0, min = 0.0, max = 0.0;
};

/// {name: number} of all, lists of three as their key with _x, _y and _z. A name is the key with
/// `_` for `/`: score_threshold.
std::map<std::string, Number> numbersOf(const Settings& settings);

/// The settings with other numbers.
/// @throws std::invalid_argument  no such number, out of its range, or at odds with the others:
///         name, value, allowed. Not a list that is not there, if it would stay so (zero).
Settings withNumbers(Settings settings, const std::map<std::string, double>& values);

/// {where it stands in the cell's file: value as YAML} of all numbers and lists of numbers.
std::map<YamlPath, std::string> yamlOf(const Settings& settings);

}  // namespace planar_bin_picking_ros
