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

/// @param score_min  poses below are left out
std::vector<Detection> rankPoses(const std::vector<ScoredPose>& scored,
                                 const std::vector<std::shared_ptr<const PartModel>>& parts,
                                 double score_min, const RankParams& params);

}  // namespace planar_bin_picking
