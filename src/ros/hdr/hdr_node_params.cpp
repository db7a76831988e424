// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hdr/hdr_node_params.h"

#include "shared/names.h"
#include "shared/param_reader.h"

#include <cmath>
#include <stdexcept>

namespace planar_bin_picking_ros {

namespace {

void require(const bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument(message);
}

}  // namespace

void validate(const HdrNodeParams& params) {
  require(params.exposures_ms.size() >= 2,
          "~hdr/exposures_ms must list at least two exposure times, such as [2, 8, 32]");
  for (const double ms : params.exposures_ms) {
    require(std::isfinite(ms) && ms > 0.0 && ms <= 60000.0,
            "~hdr/exposures_ms has " + std::to_string(ms) + ", must lie in 0 .. 60000, without 0");
  }
  if (params.hasService()) {
    require(params.single_ms > 0.0,
            "~hdr/exposure_service is set: set ~hdr/single_ms, too, since a service cannot be "
            "asked which exposure the camera has");
  } else {
    require(!params.camera_node.empty() && !params.exposure_parameter.empty(),
            "set ~hdr/camera_node and ~hdr/exposure_parameter, or ~hdr/exposure_service");
  }
  require(params.trigger_service.empty() || params.triggers_max >= params.blind_frames,
          "~hdr/triggers_max is " + std::to_string(params.triggers_max) +
              ", must be at least ~hdr/blind_frames, which is " +
              std::to_string(params.blind_frames));
  planar_bin_picking::validate(params.merge);
}

HdrNodeParams loadHdrNodeParams(const XmlRpc::XmlRpcValue& tree) {
  HdrNodeParams params = readFields<HdrNodeParams>(tree, kHdrParams);
  validate(params);
  return params;
}

std::string describe(const HdrNodeParams& params) { return printFields(params); }

}  // namespace planar_bin_picking_ros
