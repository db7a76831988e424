// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a hole is seen where a pose has it, or clearly elsewhere: moved or of another size, as
/// in a part whose drawing differs by this hole.

#include "image/edge_search.h"

#include <vector>

namespace planar_bin_picking {

/// What the edges about one drawn hole tell of it.
struct HoleEvidence {
  double here = 0.0;  ///< inlier score of the hole as the pose has it, 0..1
  /// By how much the best other place or size near it is likelier than that, up to 1; 0 where none
  /// is, or where none was sought. Of two edges on one normal the higher one is the rim: the lower
  /// one may be a shadow in the hole, or what lies below it.
  double lead = 0.0;
};

/// @param points    of one hole, all around
/// @param width_px  of the hole in the image; another place is not sought for a narrow one, both of
///                  whose rims lie within one profile
/// Cost: as much as scoring the hole; some 20 times as much where the hole is not seen.
HoleEvidence holeEvidence(const EdgeMap& edges, const Camera& camera,
                          const std::vector<LocalPoint>& points, const Solid& solid,
                          const Eigen::Isometry3d& T_camera_centre, double width_px);

}  // namespace planar_bin_picking
