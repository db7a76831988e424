// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What an integrator sets for the HDR node, below `~hdr`; see config/hdr.yaml. The defaults stand
/// here and nowhere else.

#include "planar_bin_picking/image/hdr.h"

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>
#include <vector>

namespace planar_bin_picking_ros {

struct HdrNodeParams {
  std::vector<double> exposures_ms = {2.0, 8.0, 32.0, 128.0};
  double single_ms = 0.0;  ///< outside a bracket; 0 = what the camera has when a bracket begins

  std::string camera_node = "camera";           ///< that has dynamic_reconfigure
  std::string exposure_parameter = "exposure";  ///< its name there, an int or a double
  double exposure_unit_seconds = 1e-6;          ///< seconds that 1 stands for in it
  std::string exposure_service;                 ///< SetExposure.srv, in place of the three above

  std::string trigger_service;  ///< std_srvs/Trigger, for cameras that take a frame on request only

  double command_timeout = 2.0;     ///< s, wall time, for the camera to take a command in
  double frame_timeout = 2.0;       ///< s, wall time, for a frame with the new exposure to come
  double bracket_timeout = 30.0;    ///< s, wall time, after which no further exposure begins
  int triggers_max = 10;            ///< frames asked for, for one exposure, with trigger_service
  double exposure_tolerance = 0.2;  ///< relative, of the exposure that a frame shows
  int blind_frames = 3;  ///< that one is taken on trust whose grey levels tell nothing (all white)
  int threads = 0;       ///< 0 = as many as the machine has cores
  planar_bin_picking::HdrParams merge;

  bool hasService() const { return !exposure_service.empty(); }

  /// As CellParams::fields; the core's keys stand below `merge/`.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("exposures_ms", self.exposures_ms);
    visit("single_ms", self.single_ms, 0.0, 60000.0);
    visit("camera_node", self.camera_node);
    visit("exposure_parameter", self.exposure_parameter);
    visit("exposure_unit_seconds", self.exposure_unit_seconds, 1e-9, 1.0);
    visit("exposure_service", self.exposure_service);
    visit("trigger_service", self.trigger_service);
    visit("command_timeout", self.command_timeout, 0.01, 60.0);
    visit("frame_timeout", self.frame_timeout, 0.01, 60.0);
    visit("bracket_timeout", self.bracket_timeout, 0.01, 600.0);
    visit("triggers_max", self.triggers_max, 1, 1000);
    visit("exposure_tolerance", self.exposure_tolerance, 0.01, 1.0);
    visit("blind_frames", self.blind_frames, 1, 100);
    visit("threads", self.threads, 0, 64);
    planar_bin_picking::HdrParams::fields(
        self.merge, [&](const std::string& key, auto& member, auto min, auto max) {
          visit("merge/" + key, member, min, max);
        });
  }
};

/// @throws std::invalid_argument  naming the key: fewer than two exposures, one that is not
///         positive, a service without single_ms, fewer triggers than blind frames
void validate(const HdrNodeParams& params);

/// @param tree  as readTree returns it
/// @throws std::invalid_argument  unknown key, wrong type or value out of range: key, value,
/// allowed; or as validate
HdrNodeParams loadHdrNodeParams(const XmlRpc::XmlRpcValue& tree);

/// "key: value" of every field, one a line, for the log at start.
std::string describe(const HdrNodeParams& params);

}  // namespace planar_bin_picking_ros
