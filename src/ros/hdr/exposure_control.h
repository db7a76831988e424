// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Tells a camera its exposure time, by dynamic_reconfigure or by SetExposure. Every call ends
/// within command_timeout, also when the driver hangs.

#include "hdr/hdr_node_params.h"

#include <dynamic_reconfigure/Config.h>
#include <ros/node_handle.h>

#include <string>

namespace planar_bin_picking_ros {

class ExposureControl {
 public:
  ExposureControl(const ros::NodeHandle& nh, const HdrNodeParams& params);

  /// The exposure outside a bracket, seconds: single_ms, or what the camera has now.
  /// @throws std::runtime_error  the camera cannot be asked, or has no such parameter
  double single();

  /// @pre single() was called before: it learns the parameter's type, too.
  /// @throws std::runtime_error  nobody answers, not in time, or the camera says that it uses
  /// another
  ///         exposure: what was asked, of whom, and what to check
  void set(double seconds);

 private:
  template <class Service>
  void call(Service* service);
  /// @return  what the camera says that it uses now, seconds
  double command(double seconds);
  double secondsIn(const dynamic_reconfigure::Config& config);

  const HdrNodeParams params_;
  bool is_whole_ = false;  ///< the parameter is an int
  ros::NodeHandle nh_;
  std::string service_;  ///< resolved
};

}  // namespace planar_bin_picking_ros
