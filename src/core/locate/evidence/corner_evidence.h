// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether edges end where the outer contour turns a corner. The edge of a part does; that of a
/// bin's rim, of a table or of a larger part goes straight on, though a part's straight sides fit
/// along it as well as along their own.

#include "image/edge_search.h"

#include <optional>
#include <vector>

namespace planar_bin_picking {

/// A straight side of the outer contour up to one of its two corners, and the line beyond it.
/// Points about the centre of the outline, in radii (outline_view.h), from the corner away.
struct SideEnd {
  std::vector<LocalPoint> side;
  std::vector<LocalPoint> beyond;    ///< only where nothing of the part lies
  std::vector<double> from_contour;  ///< of `beyond`: distance from the outer contour, radii
};

/// Of the longest straight sides. A round contour has none.
/// Cost: O(sides * points of the outer loop)
std::vector<SideEnd> sideEndsOf(const PartModel& part);

/// Where the part's contour would lie in the picture.
struct PosedPart {
  Solid solid;
  Eigen::Isometry3d T_camera_centre;
  double edge_offset = 0.0;    ///< radii, into the material
  double px_per_radius = 0.0;  ///< where it is seen narrowest
};

/// @return  0..1: mean inlier score of the lines beyond the sides' corners, less what chance gives,
///          each weighted by how well its side is seen. Nothing where no side's end is seen.
std::optional<double> edgesBeyondCorners(const EdgeMap& edges, const Camera& camera,
                                         const std::vector<SideEnd>& ends, const PosedPart& posed,
                                         double reach_px);

}  // namespace planar_bin_picking
