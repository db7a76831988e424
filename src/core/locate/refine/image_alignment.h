// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Second part of stage 3: sub-pixel edges along the outline's normals in the raw image, with the
/// full lens model.

#include "image/edge_search.h"

#include <limits>
#include <vector>

namespace planar_bin_picking {

/// Fewer edges do not hold six unknowns against what is wrong with some of them.
inline constexpr int kFewEdges = 8;

struct ImagePose {
  Eigen::Isometry3d T_camera_centre = Eigen::Isometry3d::Identity();
  double residual_px = 0.0;  ///< robust standard deviation of the offsets
  /// Of xi (translation in radii). Neighbouring points err alike (light, bevel, a neighbour's
  /// edge), so stretches of the outline count as the independent observations: the cluster-robust
  /// (sandwich) estimate. Before anything is seen, and where edges are too few, a radius and a
  /// radian; so it stays in directions that no edge holds.
  Matrix6d covariance = Matrix6d::Identity();
  Vector6d per_inset = Vector6d::Zero();  ///< how xi follows an error of the inset, both in radii
  int used = 0;  ///< points with a weight; where fewer than kFewEdges, the pose is left alone
  /// By how much the edges lie inside the outline everywhere (a bevelled cut edge), as this pose
  /// alone tells, and its standard deviation; both in radii, infinite where it cannot tell.
  double inset = 0.0, inset_sigma = std::numeric_limits<double>::infinity();
};

/// One association and a few damped, re-weighted Gauss-Newton steps with Tukey weights of width
/// `tukey_px`. Cost: O(points * reach).
ImagePose stepInImage(const EdgeMap& edges, const Camera& camera,
                      const std::vector<LocalPoint>& points, const Solid& solid,
                      const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                      double tukey_px);

}  // namespace planar_bin_picking
