// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// An answer for people: outlines and names as markers, for rviz.

#include "planar_bin_picking/part/part_model.h"

#include <planar_bin_picking/LocatedPart.h>
#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include <vector>

namespace planar_bin_picking_ros {

/// One answer's markers; the first one deletes those of the answer before.
/// @param parts  all that `located` names
visualization_msgs::MarkerArray makeMarkers(
    const std_msgs::Header& header, const std::vector<planar_bin_picking::LocatedPart>& located,
    const std::vector<planar_bin_picking::PartPtr>& parts);

}  // namespace planar_bin_picking_ros
