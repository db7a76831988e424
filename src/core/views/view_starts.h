// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Where a part may be, given where one view has it: nearer, farther, tilted the other way.

#include "locate/align/image_alignment.h"
#include "views/seen_part.h"

#include <vector>

namespace planar_bin_picking {

/// A start for the joint alignment, and how the new view likes it.
struct ViewStart {
  Eigen::Isometry3d T_first_centre = Eigen::Isometry3d::Identity();  ///< as the first view has it
  ImagePose own;       ///< the new view's own pose, aligned from there
  double score = 0.0;  ///< its inlier score
};

/// @param reach  metres of depth to either side
/// @return       the pose itself first; steps so small that none misses the part in the new view
std::vector<Eigen::Isometry3d> startsAbout(const SeenPart& seen,
                                           const Eigen::Isometry3d& T_first_centre,
                                           const View& view, double reach);

/// Aligned in the new view by itself, the best first, each another place; a few of them.
std::vector<ViewStart> bestStarts(const SeenPart& seen, const View& view, double offset,
                                  const std::vector<Eigen::Isometry3d>& starts, int threads);

/// Mean over the points, see evidence/inlier_score.h.
double scoreIn(const SeenPart& seen, const View& view, const Eigen::Isometry3d& T_view_centre,
               const std::vector<LocalPoint>& points);

}  // namespace planar_bin_picking
