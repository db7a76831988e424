// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 2: EdgeMap x part -> candidates, by voting over distance, yaw, x, y, face and
/// foreshortening.
///
/// Differs from [1] Sec. II-B in form, not in what is counted: instead of edgels voting, each view
/// of the outline is correlated with the distance field ([3]'s idea), whole rows of positions at a
/// time. Tilt tolerance: besides the tolerance of the cells, tilted views are voted for, too.

#include "planar_bin_picking/edge_map.h"
#include "planar_bin_picking/part_model.h"

#include <vector>

namespace planar_bin_picking {

struct HoughParams {
  double radius_cells = 14.0;    ///< cells of the accumulator along the part's radius
  double tolerance_cells = 1.0;  ///< an edgel this far off still counts a little
  double yaw_step_deg = 5.0;
  double distance_step = 0.06;  ///< relative
  double tilt_max_deg = 40.0;
  int raster_points = 80;  ///< along the outline
  double votes_min = 0.3;  ///< share of the highest possible vote
  int tile_cells = 4;
  int max_candidates = 800;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("radius_cells", self.radius_cells, 4.0, 64.0);
    visit("tolerance_cells", self.tolerance_cells, 0.25, 4.0);
    visit("yaw_step_deg", self.yaw_step_deg, 0.5, 30.0);
    visit("distance_step", self.distance_step, 0.005, 0.5);
    visit("tilt_max_deg", self.tilt_max_deg, 0.0, 60.0);
    visit("raster_points", self.raster_points, 16, 85);
    visit("votes_min", self.votes_min, 0.0, 1.0);
    visit("tile_cells", self.tile_cells, 1, 64);
    visit("max_candidates", self.max_candidates, 2, 100000);
  }
};

/// What of a part is looked for.
struct HoughTask {
  const PartModel* part = nullptr;
  std::size_t part_index = 0;  ///< passed on in Candidate::part
  double distance_min = 0.0, distance_max = 0.0;
};

/// @return  candidates, votes descending, ties by position and view; at most params.max_candidates
/// @throws std::invalid_argument  the search would take more than 1 GB, by the parameters' fault
/// Source: [1] Sec. II-B, II-C. Cost: at most O(views * raster points * cells), of which the bars
/// of the bins found so far (vote_planes.h) save about half.
std::vector<Candidate> findCandidates(const EdgeMap& edges, const HoughTask& task,
                                      const HoughParams& params, int threads);

}  // namespace planar_bin_picking
