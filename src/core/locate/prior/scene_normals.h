// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How the parts of a picture lie, as a prior on one of them of which the picture leaves two tilts
/// open.
///
/// Many of a heap lie flat on the floor or on one another and share one normal to a degree or so;
/// the others lean by tens of degrees in any direction. One spread for all would be as wide as
/// these. So the density is that of the normals themselves, each a kernel as wide as it is measured
/// (Parzen's window), and a wide share for what lies as no other.

#include "planar_bin_picking/base/types.h"

#include <vector>

namespace planar_bin_picking {

/// One way in which a part may lie.
struct SceneNormal {
  Eigen::Vector3d normal_camera;
  double variance;     ///< rad^2 per axis, as measured
  double probability;  ///< 0..1, or as how many parts it counts
  std::size_t part;    ///< those of one number are ways in which one part may lie
};

/// Logarithm of the density, but for a constant, with which part number `left_out` has this normal,
/// as the other parts tell. 0 where there are none.
/// @param variance  of the measured normal, rad^2 per axis
/// Cost: O(normals).
double logTiltDensity(const std::vector<SceneNormal>& scene, const Eigen::Vector3d& normal_camera,
                      double variance, std::size_t left_out);

}  // namespace planar_bin_picking
