// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planar_bin_picking/part_model.h"

#include <vector>

namespace planar_bin_picking {

/// All lookalikes of a part with an outline and a symmetry. Exact symmetries that no print tells apart are
/// left out.
/// @param tolerance  how far a point may lie off the outline, in radii of the part
/// @param share_min  share of the outline that must lie on itself
std::vector<Lookalike> findLookalikes(const PartModel& part, double tolerance = 0.03,
                                      double share_min = 0.7);

}  // namespace planar_bin_picking
