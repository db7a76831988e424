// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Edges that poses explain, and what is left for another one.
///
/// The gaps of a comb look like a second comb that lies in them, and the gap between two bars like
/// a third: each of its edges is seen, but it is the edge of the part on its other side. So what a
/// better pose explains from the other side confirms nothing.

#include "planar_bin_picking/base/types.h"

#include <cstdint>
#include <vector>

namespace planar_bin_picking {

class ExplainedEdges {
 public:
  /// @param poses  all that will be added or asked about: their outlines bound the image
  /// Memory: a byte for each 3 x 3 pixels.
  explicit ExplainedEdges(const std::vector<const ScoredPose*>& poses);

  /// Its outline is taken for what it is.
  void add(const ScoredPose& pose);

  /// Mean inlier score of the outline's points that none of the added poses explains from the other
  /// side, 0..1; the pose's score where hardly any are left.
  double ownScore(const ScoredPose& pose) const;

 private:
  int cols_ = 0, rows_ = 0;
  std::vector<std::uint8_t> directions_;  // by cell, a bit for each direction of an outward normal
};

}  // namespace planar_bin_picking
