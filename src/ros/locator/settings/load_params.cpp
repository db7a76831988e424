// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/settings/load_params.h"

#include "shared/names.h"
#include "shared/param_reader.h"

namespace planar_bin_picking_ros {

using planar_bin_picking::LocatorParams;
using XmlRpc::XmlRpcValue;

namespace {

const auto kEachField = [](auto& params, auto& visit) {
  planar_bin_picking::forEachField(params, visit);
};

}  // namespace

LocatorParams loadLocatorParams(const XmlRpcValue& tree) {
  const LocatorParams params = readFields<LocatorParams>(tree, kLocatorParams, kEachField);
  planar_bin_picking::validate(params);
  return params;
}

CellParams loadCellParams(const XmlRpcValue& tree) {
  CellParams params = readFields<CellParams>(tree, kCellParams);
  validate(params);
  return params;
}

planar_bin_picking::PickParams loadPickParams(const XmlRpcValue& tree) {
  return readFields<planar_bin_picking::PickParams>(tree, kPickParams);
}

std::string describe(const LocatorParams& params) { return printFields(params, kEachField); }

std::string describe(const CellParams& params) { return printFields(params); }

std::string describe(const planar_bin_picking::PickParams& params) { return printFields(params); }

}  // namespace planar_bin_picking_ros
