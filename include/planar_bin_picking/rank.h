// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 5: ScoredPose -> Detection: duplicates suppressed, best first.

#include "planar_bin_picking/part_model.h"
#include "planar_bin_picking/types.h"

#include <memory>
#include <vector>

namespace planar_bin_picking {

struct RankParams {
  double overlap_max = 0.5;  ///< of two outlines that share more of their area the better one stays

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("overlap_max", self.overlap_max, 0.0, 1.0);
  }
};

/// @param score_min  poses below are left out
std::vector<Detection> rankPoses(const std::vector<ScoredPose>& scored,
                                 const std::vector<std::shared_ptr<const PartModel>>& parts,
                                 double score_min, const RankParams& params);

}  // namespace planar_bin_picking
