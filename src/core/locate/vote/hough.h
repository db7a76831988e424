// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 2: EdgeMap x part -> candidates, by voting over distance, yaw, x, y, face and
/// foreshortening.
///
/// Differs from [1] Sec. II-B in form, not in what is counted: instead of edgels voting, each view
/// of the outline is correlated with the distance field ([3]'s idea), whole rows of positions at a
/// time. Tilt tolerance: besides the tolerance of the cells, tilted views are voted for, too.

#include "image/edge_map.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/part/part_model.h"

#include <vector>

namespace planar_bin_picking {

/// What of a part is looked for.
struct HoughTask {
  const PartModel* part = nullptr;
  std::size_t part_index = 0;  ///< passed on in Candidate::part
  double distance_min = 0.0, distance_max = 0.0;
};

/// @return  candidates, votes descending, ties by position and view; at most params.max_candidates
/// @throws std::invalid_argument  the search would take more than 1 GB, by the parameters' fault
/// Source: [1] Sec. II-B, II-C. Cost: at most O(views * raster points * cells), of which the
/// pruning thresholds of the bins found so far (vote_planes.h) save about half.
std::vector<Candidate> findCandidates(const EdgeMap& edges, const HoughTask& task,
                                      const HoughParams& params, int threads);

}  // namespace planar_bin_picking
