// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Turns after which a part's outline all but lies on itself, found from the drawing.

#include "planar_bin_picking/drawing/symmetry.h"
#include "planar_bin_picking/part/outline.h"

#include <vector>

namespace planar_bin_picking {

/// A turn of the part (also upside down) after which most of its outline lies on itself again: a
/// sprocket's other teeth, a plate's other way round, the face that only a print tells from the
/// other. A pose that was found could as well be any of these.
struct NearSymmetry {
  Eigen::Isometry3d T_part_turned = Eigen::Isometry3d::Identity();
  bool flips = false;  ///< shows the other face
  bool exact = false;  ///< the shape is symmetric; only the print differs
  /// Shape points (indices into outline()) of the turned part that lie off the part's own outline,
  /// and the reverse: only these can tell the two apart.
  std::vector<int> only_turned, only_part;
};

/// What is searched for them.
struct OutlineShape {
  const std::vector<OutlinePoint>& points;  ///< as sampleOutline returns them
  const Symmetry& symmetry;                 ///< without the prints
  double radius, thickness;                 ///< metres
  bool has_print;
};

/// All near-symmetries. Exact symmetries that no print tells apart are left out.
/// @param tolerance  how far a point may lie off the outline, in radii of the part
/// @param share_min  share of the outline that must lie on itself
std::vector<NearSymmetry> findNearSymmetries(const OutlineShape& part, double tolerance = 0.05,
                                             double share_min = 0.7);

/// Largest n for which every turn by 360/n degrees is a symmetry or a near-symmetry that shares at
/// least `share_min` of the outline; 0 for a full circle. See PartModel::nearOrder.
int findNearOrder(const OutlineShape& part, const std::vector<NearSymmetry>& near_symmetries,
                  double share_min = 0.9);

}  // namespace planar_bin_picking
