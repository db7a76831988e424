// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 5: ScoredPose -> Detection: duplicates suppressed, best first.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/part/part_model.h"

#include <memory>
#include <vector>

namespace planar_bin_picking {

/// In each place the best confirmed one, by PoseEvidence::edges times the square of the visible
/// fraction. These are ordered by the same, where edges count times the probability of the tilt
/// (probability.h): the other one of two tilts that a picture leaves open may be the right one.
/// @param score_min  poses below are left out
std::vector<Detection> rankPoses(const std::vector<ScoredPose>& scored,
                                 const std::vector<std::shared_ptr<const PartModel>>& parts,
                                 double score_min, const RankParams& params);

}  // namespace planar_bin_picking
