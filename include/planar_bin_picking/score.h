// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 4: RefinedPose -> ScoredPose: what speaks for a pose, and how much of the part is
/// uncovered (src/core/cover.h).
///
/// The score is the mean support (Eq. 12 of [1], noise excluded, less with distance) of outer
/// contour, holes and print, each counting the same. Differs from [1] Sec. III-D, which averages
/// over all points: holes are short but hardly ever matched by chance (measured in test/benchmark).

#include "planar_bin_picking/camera.h"
#include "planar_bin_picking/edge_map.h"
#include "planar_bin_picking/part_model.h"

#include <memory>
#include <vector>

namespace planar_bin_picking {

struct ScoreParams {
  double threshold = 0.65;        ///< detections below are not returned
  double reach_px = 1.5;          ///< an edge this far off the outline no longer supports it
  int points = 256;               ///< along each of outer contour, holes, print
  double visible_reach_px = 2.5;  ///< the same, for what counts as seen

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("threshold", self.threshold, 0.0, 1.0);
    visit("reach_px", self.reach_px, 0.2, 10.0);
    visit("points", self.points, 32, 2048);
    visit("visible_reach_px", self.visible_reach_px, 0.2, 10.0);
  }
};

/// @return  as many as refined, in the same order
std::vector<ScoredPose> scorePoses(const EdgeMap& edges, const Camera& camera,
                                   const std::vector<std::shared_ptr<const PartModel>>& parts,
                                   const std::vector<RefinedPose>& refined,
                                   const ScoreParams& params, int threads);

}  // namespace planar_bin_picking
