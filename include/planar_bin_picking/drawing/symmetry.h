// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Rotation and mirror symmetry of an outline, found from the outline itself.

#include "planar_bin_picking/drawing/drawing.h"

namespace planar_bin_picking {

/// Symmetry of the outer loop and the holes taken together; `_print` of these with the print.
struct Symmetry {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< centroid of the material, metres
  int order = 1;             ///< order of rotation about the centre; 0 = full circle
  int order_print = 1;       ///< the same, with the print drawn on the face
  bool mirror = false;       ///< the outline equals its mirror image
  double mirror_axis = 0.0;  ///< direction of one mirror axis through the centre, rad, in [0, pi)
};

/// @param tolerance  how far, in metres, a mapped outline may lie off the outline
Symmetry findSymmetry(const Drawing& drawing, double tolerance = 0.05e-3);

}  // namespace planar_bin_picking
