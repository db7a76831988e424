// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Which cells of a posed part's face something covers.
///
/// What covers a part shows twice: sections of the part's own outline are missing, and the contour
/// of the covering part runs across the face. A missing section alone may as well be faint, a
/// foreign edge alone a scratch. So the cells are divided by a minimum cut (Y. Boykov,
/// V. Kolmogorov: PAMI 26(9), 2004): outline that is seen binds its cells to one side, outline that
/// is missing to the other, and a border between the two costs little where the face's brightness
/// changes by more than its texture does.

#include "locate/judge/flat_face.h"

#include <vector>

namespace planar_bin_picking {

/// A piece of the outline, and whether its edge is seen.
struct OutlinePiece {
  Eigen::Vector2d position, normal;  ///< part frame; the normal points out of the material
  double length = 0.0;               ///< metres
  bool seen = false;
  int loop = 0;  ///< index into Drawing::loops
};

/// @param flat  of flatten
/// @return      covered cells in order; what lies outside the image counts as covered
std::vector<int> findOcclusion(const FaceGrid& grid, const FlatFace& flat,
                               const std::vector<OutlinePiece>& outline);

}  // namespace planar_bin_picking
