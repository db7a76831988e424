// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a print is where a pose has it. Drawings give prints as the centre lines of strokes of
/// any width, or as the borders of filled areas, darker or lighter than the part.

#include "image/edge_map.h"
#include "part/outline_view.h"
#include "planar_bin_picking/image/camera.h"

#include <vector>

namespace planar_bin_picking {

/// @param points  of the print, in order along its lines
/// @return  share of the points at which there is a stroke or a border, all of one polarity, 0..1;
///          some 0.1 to 0.3 by chance
double printScore(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
                  double radius, const Eigen::Isometry3d& T_camera_centre);

}  // namespace planar_bin_picking
