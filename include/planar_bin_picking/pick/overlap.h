// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What of a located part's face lies below other located parts. Where two parts of the same metal
/// touch, the picture may hardly show that one covers the other; their poses do.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_model.h"

#include <Eigen/Geometry>

#include <vector>

namespace planar_bin_picking {

/// A located part and the face that is up.
struct LyingFace {
  const PartModel* part;
  Face face;
  Eigen::Isometry3d T_target_part;
  /// Middles of the cells that something covers as the picture shows it, part frame.
  std::vector<Eigen::Vector2d> covered = {};
};

/// Cells of a part's face over which another part lies, in order. By their poses, whose depth may
/// be off by as much as a thin part is thick: so where the picture shows the other one to be
/// covered, it is not the upper one.
std::vector<int> cellsBelow(const LyingFace& own, const LyingFace& other);

}  // namespace planar_bin_picking
