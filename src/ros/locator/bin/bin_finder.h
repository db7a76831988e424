// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// LocateBin: a bin that stands otherwise than the cell's file says, found by its rim, and from
/// then on in force if the caller wants it.

#include "input/image_inbox.h"
#include "input/picture_host.h"
#include "planar_bin_picking/bin/bin_pose.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locator.h"

#include <planar_bin_picking/LocateBin.h>
#include <ros/node_handle.h>

#include <Eigen/Geometry>

#include <functional>
#include <mutex>
#include <optional>
#include <string>

namespace planar_bin_picking_ros {

class BinFinder {
 public:
  /// As in CellParams.
  struct Settings {
    std::string bin_frame, target_frame;
    planar_bin_picking::BinSearch search;  ///< but for T_camera_bin
    /// Where it was found before, and is in force.
    Eigen::Isometry3d T_told_found = Eigen::Isometry3d::Identity();
  };
  /// What it needs of the locator.
  struct Host : PictureHost {
    std::function<Settings()> settings;  ///< as they are now
    /// From now on the bin stands so from where the file has it.
    std::function<void(const Eigen::Isometry3d& T_told_found)> use;
    /// With its parameters as they are now.
    std::function<planar_bin_picking::Locator()> locator;
  };

  /// @param call_pnh  its queue serves calls
  /// @throws std::invalid_argument  the bin in force is farther off than the limits allow
  BinFinder(Host host, const ros::NodeHandle& call_pnh);
  void close() { service_.shutdown(); }

 private:
  using Request = planar_bin_picking::LocateBin::Request;
  using Response = planar_bin_picking::LocateBin::Response;

  bool serve(Request& request, Response& response);
  void answer(const Request& request, Response* response);
  /// What a former process has found is in force.
  void begin();
  std::optional<planar_bin_picking::FoundBin> find(const Frame& frame, const Settings& settings);

  const Host host_;
  ros::Publisher topic_;
  ros::ServiceServer service_;
};

}  // namespace planar_bin_picking_ros
