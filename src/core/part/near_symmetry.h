// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planar_bin_picking/part/part_model.h"

#include <vector>

namespace planar_bin_picking {

/// All lookalikes of a part with an outline and a symmetry. Exact symmetries that no print tells
/// apart are left out.
/// @param tolerance  how far a point may lie off the outline, in radii of the part
/// @param share_min  share of the outline that must lie on itself
std::vector<NearSymmetry> findNearSymmetries(const PartModel& part, double tolerance = 0.05,
                                             double share_min = 0.7);

/// Largest n for which every turn by 360/n degrees is a symmetry or a lookalike that shares at
/// least `share_min` of the outline; 0 for a full circle. See PartModel::nearOrder.
int findNearOrder(const PartModel& part, double share_min = 0.9);

}  // namespace planar_bin_picking
