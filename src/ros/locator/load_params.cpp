// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/load_params.h"

#include "shared/names.h"
#include "shared/param_reader.h"

namespace planar_bin_picking_ros {

using planar_bin_picking::LocatorParams;
using XmlRpc::XmlRpcValue;

LocatorParams loadLocatorParams(const XmlRpcValue& tree) {
  LocatorParams params;
  ParamReader reader(tree, kLocatorParams);
  planar_bin_picking::forEachField(params, reader);
  reader.finish();
  planar_bin_picking::validate(params);
  return params;
}

CellParams loadCellParams(const XmlRpcValue& tree) {
  CellParams params;
  ParamReader reader(tree, kCellParams);
  CellParams::fields(params, reader);
  reader.finish();
  validate(params);
  return params;
}

planar_bin_picking::PickParams loadPickParams(const XmlRpcValue& tree) {
  planar_bin_picking::PickParams params;
  ParamReader reader(tree, kPickParams);
  planar_bin_picking::PickParams::fields(params, reader);
  reader.finish();
  return params;
}

std::string describe(const LocatorParams& params) {
  ParamPrinter printer;
  planar_bin_picking::forEachField(params, printer);
  return printer.text.str();
}

std::string describe(const CellParams& params) {
  ParamPrinter printer;
  CellParams::fields(params, printer);
  return printer.text.str();
}

std::string describe(const planar_bin_picking::PickParams& params) {
  ParamPrinter printer;
  planar_bin_picking::PickParams::fields(params, printer);
  return printer.text.str();
}

}  // namespace planar_bin_picking_ros
