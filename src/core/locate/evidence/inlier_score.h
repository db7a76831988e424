// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "image/edge_search.h"

#include <algorithm>
#include <vector>

namespace planar_bin_picking {

/// Where edges that confirm an outline are sought. Pixels: twice the reach of an inlier
/// (score/reach_px), so that an edge just beyond is not taken for a nearer one; a sharp edge's
/// sigma.
inline constexpr SearchProfile kInlierProfile{3, true, 0.8};

/// How well the edge that one outline point found confirms it, 0..1: Eq. (12)'s |cos|, less with
/// distance. Noise counts nothing.
inline double inlierScore(const EdgeHit& hit, double reach_px) {
  if (!hit.found) return 0.0;
  // The wall's lower edge is as good evidence of the pose as the upper one.
  const double beyond =
      hit.offset_px > 0.0f ? std::max(0.0f, hit.offset_px - hit.wall_px) : hit.offset_px;
  const double off = beyond / reach_px;
  return std::max(0.0, 1.0 - off * off) * hit.cosine;
}

/// Mean over the points: Psi of Eq. (12) with the above.
inline double inlierScore(const std::vector<EdgeHit>& hits, double reach_px) {
  double sum = 0.0;
  for (const auto& hit : hits) sum += inlierScore(hit, reach_px);
  return hits.empty() ? 0.0 : sum / static_cast<double>(hits.size());
}

}  // namespace planar_bin_picking
