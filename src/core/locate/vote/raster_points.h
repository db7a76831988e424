// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The points of an outline that vote, and where in the planes those of a view lie.

#include "locate/vote/vote_planes.h"
#include "planar_bin_picking/part/part_model.h"

#include <Eigen/Geometry>

#include <vector>

namespace planar_bin_picking {

/// By component: the compiler takes several at once.
struct RasterPoints {
  static constexpr int kLanes = 16;
  int count = 0;
  std::vector<double> x, y;    ///< metres from the part's centre
  std::vector<double> nx, ny;  ///< outward normals; all to a multiple of kLanes, filled by the last

  /// Samples of the outline, prints left out: those tell the face later (print_evidence.h).
  RasterPoints(const PartModel& part, int count);
};

/// Where a view has the points.
/// @param to_half    part -> half cells
/// @param to_normal  normals of the part -> of the view, any length
/// @param cells      of VotePlanes::offset; there is room for all points
/// @return           about the points, half cells
Eigen::AlignedBox2d placePoints(const RasterPoints& points, const Eigen::Matrix2d& to_half,
                                const Eigen::Matrix2d& to_normal, const VotePlanes& planes,
                                std::int32_t* cells);

}  // namespace planar_bin_picking
