// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What stands about the parts, as markers for rviz: bin, region, camera and plane. Each is in its
/// own frame with a stamp of zero, so that rviz shows it where tf has that frame at the moment.

#include "planar_bin_picking/bin/region.h"
#include "planar_bin_picking/image/camera.h"

#include <visualization_msgs/Marker.h>

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace planar_bin_picking_ros {

using Markers = std::vector<visualization_msgs::Marker>;

/// The edges of the box, and its floor as a sheet that one can click on.
/// @param T_frame_bin  the bin may have been found elsewhere than its frame is
Markers binMarkers(const std::string& frame, const Eigen::Isometry3d& T_frame_bin,
                   const Eigen::Vector3d& min, const Eigen::Vector3d& max);

/// The region in force, and the points that were clicked since with the lines between them.
/// @param T_frame_region  the bin, and the region with it, may have been found elsewhere
/// @param good            whether the points can be saved; else they are red
Markers regionMarkers(const std::string& frame, const Eigen::Isometry3d& T_frame_region,
                      const planar_bin_picking::RegionOutline& region,
                      const planar_bin_picking::RegionOutline& points, bool good);

/// Where a camera is and what it sees up to a distance.
struct ShownCamera {
  const char* ns;     ///< of the frustum
  std::string frame;  ///< in which T_frame_camera is
  Eigen::Isometry3d T_frame_camera = Eigen::Isometry3d::Identity();
  const planar_bin_picking::Camera& camera;
  double distance = 1.0;                          ///< metres
  planar_bin_picking::RegionOutline region = {};  ///< pixels
  std::string text = {};                          ///< at the camera
};
Markers cameraMarkers(const ShownCamera& shown);

/// z = 0 of a frame.
Markers planeMarkers(const std::string& frame);

}  // namespace planar_bin_picking_ros
