// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The calibration's poses for rviz.

#include "planar_bin_picking/calibration_run.h"

#include <visualization_msgs/MarkerArray.h>

#include <string>

namespace planar_bin_picking_ros {

/// Flange axes at every pose: planned blue, visited green, refused red; the first marker deletes
/// what was shown before.
visualization_msgs::MarkerArray makePlanMarkers(
    const std::string& base_frame, const std::vector<planar_bin_picking::PlannedPose>& poses);

}  // namespace planar_bin_picking_ros
