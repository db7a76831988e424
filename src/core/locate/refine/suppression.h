// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Non-maximum suppression between the steps of stage 3.

#include "locate/refine/pose_hypothesis.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace planar_bin_picking {

/// How many poses of a part stay: the best `least` whatever their score, `most` in any case.
struct PoseLimits {
  int least, most;
};

/// Indices of the poses that stay, best first: of those that agree within `distance` radii
/// (pose_distance.h) only the best, none below `score_min` but for the limits.
std::vector<std::size_t> withoutDuplicates(const std::vector<PoseHypothesis>& poses,
                                           const std::vector<PartOutline>& outlines,
                                           double distance, double score_min,
                                           const PoseLimits& limits);

/// Indices, in order, of those that no clearly better pose outscores that is seen where they are:
/// of one part by more than `overlap_max` of either face, of another one by more than that of both,
/// since a small part may lie on a large one. Of them the rank would answer one at most, by the
/// areas of its own masks (rank.h).
std::vector<std::size_t> withoutOutscored(const std::vector<PoseHypothesis>& poses,
                                          const std::vector<PartOutline>& outlines,
                                          double overlap_max);

/// Leaves the elements with these indices, in their order.
template <class T>
void keepOnly(const std::vector<std::size_t>& indices, std::vector<T>* all) {
  std::vector<T> kept;
  kept.reserve(indices.size());
  for (const std::size_t i : indices) kept.push_back(std::move((*all)[i]));
  *all = std::move(kept);
}

}  // namespace planar_bin_picking
