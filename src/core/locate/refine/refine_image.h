// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Second part of stage 3: sub-pixel edges along the outline's normals in the raw image, with the
/// full lens model.

#include "image/edge_map.h"
#include "part/outline_view.h"
#include "planar_bin_picking/image/camera.h"

#include <limits>
#include <vector>

namespace planar_bin_picking {

/// The edge that one outline point found on its normal.
struct EdgeHit {
  bool found = false;      ///< an edge above the noise within reach
  float offset_px = 0.0f;  ///< along the outward normal; negative = inside the outline
  float wall_px = 0.0f;    ///< how wide the side wall is seen outside the outline; 0 = turned away
  float cosine = 0.0f;     ///< |cos| between image gradient and normal, Eq. (12)
};

/// Size of the body behind the outline.
struct Solid {
  double radius;             ///< metres
  double far_contour = 0.0;  ///< z of the far contour in the centre frame, radii
};

inline Solid solidOf(const PartModel& part, Face face) {
  return {part.radius(), farContourOf(part, face)};
}

struct ImageReach {
  int reach_px = 6;       ///< how far along the normal an edge is sought
  bool paired = false;    ///< two profiles side by side: less noise, and the gradient's direction
  double sigma_px = 1.0;  ///< of the derivative filter
};

/// Where each point would find its edge.
void findHits(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
              const Solid& solid, const Eigen::Isometry3d& T_camera_centre, const ImageReach& reach,
              std::vector<EdgeHit>* hits);

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
                      const Eigen::Isometry3d& T_camera_centre, const ImageReach& reach,
                      double tukey_px);

}  // namespace planar_bin_picking
