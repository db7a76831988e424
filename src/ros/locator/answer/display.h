// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// An answer for people, for rviz: the parts as bodies with rank and score, grey and with the
/// reason what is not offered, and the tool at each pick pose.

#include "planar_bin_picking/part/part_model.h"
#include "planar_bin_picking/pick/tool_room.h"

#include <planar_bin_picking/LocatedPart.h>
#include <planar_bin_picking/RefusedPart.h>
#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include <vector>

namespace planar_bin_picking_ros {

/// What is shown of an answer.
struct Display {
  std_msgs::Header header;
  std::vector<planar_bin_picking::LocatedPart> located;  ///< best first
  std::vector<planar_bin_picking::RefusedPart> refused;
  std::vector<planar_bin_picking::PartPtr> parts;  ///< all that these name
  double tool_radius = 0.0;                        ///< metres, where a part's file names no other
  std::vector<planar_bin_picking::ToolBody> tool_bodies = {};  ///< on top of that cylinder
};

/// The first marker deletes those of the answer before. Namespaces: `solid`, `outline` and `name`
/// of what is offered, `refused`, `refused_outline` and `reason` of the rest, `pick`, `tool` and
/// `tool_bodies`.
visualization_msgs::MarkerArray makeMarkers(const Display& display);

}  // namespace planar_bin_picking_ros
