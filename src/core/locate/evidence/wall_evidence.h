// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a part's side wall is seen where a pose has it. With the other solution of the plane's
/// pose, tilted the other way, it would be on the other side of the part.

#include "image/edge_search.h"

#include <optional>
#include <vector>

namespace planar_bin_picking {

/// @param points  of the shape
/// @return  inlier score of the walls' lower edges, 0..1; nothing where too little of the walls is
///          in view: a wall seen narrower than two pixels does not count, and neither does one
///          whose upper edge is not seen (something covers it)
std::optional<double> wallScore(const EdgeMap& edges, const Camera& camera,
                                const std::vector<LocalPoint>& points, const Solid& solid,
                                const Eigen::Isometry3d& T_camera_centre);

}  // namespace planar_bin_picking
