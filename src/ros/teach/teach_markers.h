// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part and its pick poses as rviz shows them for teaching; pure functions.

#include "planar_bin_picking/teach/taught_part.h"

#include <visualization_msgs/InteractiveMarker.h>

#include <string>

namespace planar_bin_picking_ros {

/// The part's frame while it is taught, and what it hangs on: rviz wants a fixed frame that tf
/// knows.
constexpr char kTaughtFrame[] = "taught_part", kTeachFrame[] = "teach";
/// Name of the part's own marker; pick poses have their names, which hold no slash.
constexpr char kPartMarker[] = "/part";

/// Body, contours, holes and origin of the part, with what has happened last above it, and below it
/// in red what is wrong with which pose.
visualization_msgs::InteractiveMarker partMarker(const planar_bin_picking::TaughtPart& taught,
                                                 const std::string& news);

/// The tool's footprint, its axis and a bar along its x, with handles to move and turn it: green
/// for the front, orange for the back, red where something is wrong.
visualization_msgs::InteractiveMarker poseMarker(const planar_bin_picking::TaughtPart& taught,
                                                 const planar_bin_picking::PickPose& pose);

}  // namespace planar_bin_picking_ros
