// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Second part of stage 3: a pose is aligned to sub-pixel edges along the outline's normals.

#include "image/edge_search.h"
#include "locate/align/levenberg_marquardt.h"

#include <limits>
#include <vector>

namespace planar_bin_picking {

/// Fewer edges do not hold six unknowns against what is wrong with some of them.
inline constexpr int kFewEdges = 8;

enum class AlignmentStatus {
  kNotAligned,   ///< nothing has been looked at
  kTooFewEdges,  ///< fewer than kFewEdges with a weight: the pose is left alone
  kAligned,
};

struct ImagePose {
  AlignmentStatus status = AlignmentStatus::kNotAligned;
  Eigen::Isometry3d T_camera_centre = Eigen::Isometry3d::Identity();
  int used = 0;              ///< points with a weight
  double residual_px = 0.0;  ///< robust standard deviation of the edges' offsets
  /// Of xi (translation in radii). Neighbouring points err alike (light, bevel, a neighbour's
  /// edge), so clusters of them count as the independent observations: the sandwich estimator of
  /// clustered data. Unless the pose is aligned, a radius and a radian; so it stays in directions
  /// that no edge holds.
  Matrix6d covariance = Matrix6d::Identity();
  /// How xi follows an error of the edge offset; both in radii.
  Vector6d per_offset = Vector6d::Zero();
  /// By how much the edges lie inside the outline everywhere (a bevelled cut edge), as this pose
  /// alone tells, and its standard deviation; both in radii, infinite where it cannot tell.
  double offset = 0.0, offset_sigma = std::numeric_limits<double>::infinity();
};

/// One associated point: offset(xi) = offset + J . xi (+ edge offset * out_px).
struct AlignmentRow {
  Vector6d J;
  double offset, out_px, trust;
};

double trustOf(double wall_px, double reach_px);

/// What each point finds about the pose.
std::vector<AlignmentRow> associate(const EdgeMap& edges, const Camera& camera,
                                    const std::vector<LocalPoint>& points, const Solid& solid,
                                    const Eigen::Isometry3d& T_camera_centre,
                                    const SearchProfile& profile);

/// Tukey's biweight at xi. The pose moves by pixels within one association, so the projection
/// counts as linear there.
NormalEquations normalEquations(const std::vector<AlignmentRow>& rows, const Vector6d& xi,
                                double tukey_px);

/// Variance of a shift of the pose across the line of sight (centre axes, radii squared): light
/// from one side moves opposite edges the same way. None where no edge tells of a shift. Several
/// views under one light share it, so it is no part of imagePoseAt.
Eigen::Matrix3d lightVariance(const std::vector<AlignmentRow>& rows,
                              const Eigen::Isometry3d& T_camera_centre);

/// The pose stepped by xi, and what the edges say of it by their weights there.
ImagePose imagePoseAt(const std::vector<AlignmentRow>& rows, const Vector6d& xi, double tukey_px,
                      const Eigen::Isometry3d& T_camera_centre, double radius);

/// One association and a few steps from it: status, pose and `used` alone, where more steps follow.
/// The pose is left alone where too few edges are found.
ImagePose stepInImage(const EdgeMap& edges, const Camera& camera,
                      const std::vector<LocalPoint>& points, const Solid& solid,
                      const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                      double tukey_px);

/// The same as the last step, with what the edges say of the pose by Tukey weights of width
/// `tukey_px`; the covariance with the shift by the light, and the larger the more of the points
/// find no edge. Cost: O(points * reach).
ImagePose alignInImage(const EdgeMap& edges, const Camera& camera,
                       const std::vector<LocalPoint>& points, const Solid& solid,
                       const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                       double tukey_px);

/// The same of the pose as it is.
ImagePose lookInImage(const EdgeMap& edges, const Camera& camera,
                      const std::vector<LocalPoint>& points, const Solid& solid,
                      const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                      double tukey_px);

}  // namespace planar_bin_picking
