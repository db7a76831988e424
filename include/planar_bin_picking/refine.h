// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 3: candidate -> RefinedPose, coarse to fine.

#include "planar_bin_picking/camera.h"
#include "planar_bin_picking/edge_map.h"
#include "planar_bin_picking/part_model.h"

#include <memory>
#include <vector>

namespace planar_bin_picking {

struct RefineParams {
  /// Theta_lim of Eq. (7): beyond, a pose is penalised; what stays beyond is not answered
  /// (locator.h).
  double tilt_limit_deg = 40.0;
  int field_points = 64;
  int field_iterations = 14;
  double field_reach_radii = 0.13;  ///< radii of the part within which an edgel attracts, at first
  double field_reach_end_px = 2.0;  ///< field pixels, at last
  double field_support_min = 0.45;  ///< poses below are dropped before the image is looked at
  int max_poses = 400;              ///< of a part that go on to the image
  double image_support_min = 0.4;   ///< poses below are dropped after the first look at the image
  double search_below = 0.92;       ///< poses better supported need no search about them
  double search_support_min = 0.6;  ///< poses below are dropped after the search
  int wide_points = 128;
  int image_points = 320;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("tilt_limit_deg", self.tilt_limit_deg, 0.0, 80.0);
    visit("field_points", self.field_points, 16, 512);
    visit("field_iterations", self.field_iterations, 1, 100);
    visit("field_reach_radii", self.field_reach_radii, 0.01, 1.0);
    visit("field_reach_end_px", self.field_reach_end_px, 0.5, 20.0);
    visit("field_support_min", self.field_support_min, 0.0, 1.0);
    visit("max_poses", self.max_poses, 1, 10000);
    visit("image_support_min", self.image_support_min, 0.0, 1.0);
    visit("search_below", self.search_below, 0.0, 1.0);
    visit("search_support_min", self.search_support_min, 0.0, 1.0);
    visit("wide_points", self.wide_points, 32, 512);
    visit("image_points", self.image_points, 32, 2048);
  }
};

/// @param parts       those that Candidate::part indexes
/// @return            poses without twins, best supported first
std::vector<RefinedPose> refineCandidates(
    const EdgeMap& edges, const Camera& camera,
    const std::vector<std::shared_ptr<const PartModel>>& parts,
    const std::vector<Candidate>& candidates, const RefineParams& params, int threads);

}  // namespace planar_bin_picking
