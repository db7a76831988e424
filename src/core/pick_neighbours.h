// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What lies over a part: other located parts, and what was seen to cover its face. A part whose
/// face is all but free may still carry one that leans on its rim, and a few covered square
/// millimetres may be those that the tool needs.

#include "planar_bin_picking/pick_policy.h"

namespace planar_bin_picking {

/// Whether `upper` lies on `lower`, or so near over its rim that it may.
bool liesOn(const PickFace& upper, const PickFace& lower);

/// Whether `upper` is over the place on `lower`'s face where the tool goes, or within `radius`
/// about it.
bool isOver(const PickFace& upper, const PickFace& lower, const Eigen::Isometry3d& T_target_pick,
            double radius);

/// Whether something, seen by its cover of the face, is where the tool goes or within `radius`
/// about it.
bool isCovered(const PickFace& face, const Eigen::Isometry3d& T_target_pick, double radius);

}  // namespace planar_bin_picking
