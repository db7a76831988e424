// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 4: RefinedPose -> ScoredPose: what speaks for and against a pose.

#include "planar_bin_picking/camera.h"
#include "planar_bin_picking/edge_map.h"
#include "planar_bin_picking/part_model.h"

#include <memory>
#include <vector>

namespace planar_bin_picking {

struct ScoreParams {
  double threshold = 0.8;  ///< detections below are not returned
  int points = 512;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("threshold", self.threshold, 0.0, 1.0);
    visit("points", self.points, 32, 2048);
  }
};

/// @return  as many as refined, in the same order
std::vector<ScoredPose> scorePoses(const EdgeMap& edges, const Camera& camera,
                                   const std::vector<std::shared_ptr<const PartModel>>& parts,
                                   const std::vector<RefinedPose>& refined,
                                   const ScoreParams& params, int threads);

}  // namespace planar_bin_picking
