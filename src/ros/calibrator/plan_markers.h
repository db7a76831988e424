// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The calibration's poses for rviz.

#include "planar_bin_picking/calibrate/calibration_run.h"

#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

namespace planar_bin_picking_ros {

/// One pyramid for each pose: planned blue, seen green, refused red, board lost yellow. As long as
/// nothing is known of the camera it stands on the flange and opens along its z axis. Once there is
/// a solution it is what a camera on the flange sees from there; a camera beside the robot gets a
/// white one of its own. The first marker deletes what was shown before.
/// @param solution  provisional; null where there is none yet
visualization_msgs::MarkerArray makePlanMarkers(
    const std::string& base_frame, planar_bin_picking::Mounting mounting,
    const std::vector<planar_bin_picking::PlannedPose>& poses,
    const planar_bin_picking::HandEyeResult* solution);

/// Adds the way to the next pose as a white line, and a white pyramid at its end.
/// @param way  from where the robot stands, that place first
void addWay(const std::string& base_frame, const std::vector<Eigen::Isometry3d>& way,
            visualization_msgs::MarkerArray* array);

/// "to [0.51 0.02 0.4] m: 0.12 m and 18 deg in 2 moves".
/// @param way  as above; "" where it has no second pose
std::string describeWay(const std::vector<Eigen::Isometry3d>& way);

/// "12 poses: 8 seen, 2 refused, 1 board lost, 1 planned".
std::string summarize(const std::vector<planar_bin_picking::PlannedPose>& poses);

}  // namespace planar_bin_picking_ros
