// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// On which side of the outline, and of its holes, a narrow side wall is seen: it is a band of
/// another brightness between the face and what lies beyond. Of two tilts that leave the outline
/// alike each has the walls where the other has none.

#include "image/edge_map.h"
#include "image/edge_search.h"

#include <vector>

namespace planar_bin_picking {

/// @param points  of the shape
/// @param T_one, T_other  T_camera_centre of two poses whose outlines differ by a pixel or two (of
///          the pairs of hypotheses.cpp at 0.12 of the points by more than one); looked at is what
///          lies beside the middle of both
/// @return  how much more the bands lie where `one` has walls than where `other` has: their
///          correlation over the outline with the difference of the two walls' widths, -1..1,
///          brought nearer to 0 where that differs little, or where the blur of the face's edge
///          explains them as well; 0 where too few walls are narrow enough
/// Cost: O(points).
double wallBands(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
                 const Solid& solid, const Eigen::Isometry3d& T_one,
                 const Eigen::Isometry3d& T_other);

}  // namespace planar_bin_picking
