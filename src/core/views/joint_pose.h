// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One pose from the edges of all views: robust least squares over the pose, a correction of each
/// camera's place, and an edge offset for each view, since light and bevel make another one from
/// each side.
///
/// A row of a view sees the pose through T_view_centre = exp(-c) T_view_first T_first_centre
/// exp(xi) alone. So the rows of a view come down to a Gaussian of that view's own step and offset
/// (image_alignment.h: with what residuals cannot tell), by the weights that they have at the joint
/// pose, and the views are joined by these Gaussians and the prior of the corrections.

#include "locate/align/image_alignment.h"
#include "views/seen_part.h"

#include <vector>

namespace planar_bin_picking {

using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

/// What a view's rows say of its own step and offset; nothing where it has too few of them.
struct Said {
  bool told = false;
  Vector7d mean = Vector7d::Zero();
  Matrix7d information = Matrix7d::Zero();
  int used = 0;
};

/// By the rows' weights at xi.
Said saidBy(const std::vector<AlignmentRow>& rows, const Vector6d& xi, double tukey_px,
            double radius);

/// Of the edge offsets of so many views, radii: one that all share, and each view's own.
Eigen::MatrixXd offsetInformation(Eigen::Index views, double radius);

/// What is estimated. The first view's correction is none.
struct JointState {
  Eigen::Isometry3d T_first_centre = Eigen::Isometry3d::Identity();
  std::vector<Vector6d> corrections;  ///< by view: T_first_view * exp(c); metres, radians
  std::vector<double> offsets;        ///< by view, edge offset, radii
};

struct JointPose {
  JointState state;
  Matrix6d covariance = Matrix6d::Identity();  ///< of the face, see faceCovariance
  /// How far the views' own poses are from the joint one, in their standard deviations, squared;
  /// and of how many numbers, less those that were fitted.
  double chi_squared = 0.0;
  int freedom = 0;
  std::vector<int> used;  ///< by view: points with a weight
};

/// T_first_centre of the face. The edges that are seen run down a broken edge, whose slope is 45
/// degrees: in the mean of all they lie as far below the face as inside the drawn outline.
Eigen::Isometry3d facePose(const JointState& state, Face face, double radius);

/// Of facePose's xi, translation in radii, which follows the mean of the offsets.
/// @param covariance  of the unknowns: xi first, the offsets of the views last
Matrix6d faceCovariance(const Eigen::MatrixXd& covariance, Eigen::Index offsets, Face face);

/// What no number of views and pixels is better than, of xi with its translation in radii: where on
/// a broken edge its image lies, by which light and shadow also move a whole part aside.
/// @param depth  of the part in the first view, metres
Matrix6d leastCovariance(double radius, double depth, double focal_px);

/// T_view_centre of view k.
Eigen::Isometry3d viewPose(const JointState& state, const std::vector<ViewPtr>& views,
                           std::size_t k);

/// d(xi of T_view_centre) / d(c), the one with its translation in radii. That by xi is the
/// identity.
Matrix6d stepByCorrection(const Eigen::Isometry3d& T_view_centre, double radius);

class JointAlignment {
 public:
  /// @param views   at least two, the first one first
  /// @param offset  edge offset that is expected, metres
  JointAlignment(const SeenPart& seen, const std::vector<ViewPtr>& views, double offset,
                 const ViewsParams& params);

  /// @return  no correction, the expected offset in every view
  JointState startAt(const Eigen::Isometry3d& T_first_centre) const;

  /// Wide to narrow, from a start that is a few pixels off in each view.
  JointPose align(const JointState& start) const;

 private:
  struct Association;
  struct System;

  Association associateAll(const JointState& at, int pass) const;
  System systemAt(const JointState& start, const Association& found) const;
  /// What the views say by their rows' weights at the unknowns x.
  void weigh(const Association& found, const Eigen::VectorXd& x, double tukey_px,
             System* system) const;
  /// A few reweighted steps within one association.
  JointPose solve(const JointState& start, const Association& found, double tukey_px) const;

  const SeenPart& seen_;
  const std::vector<ViewPtr>& views_;
  std::vector<EdgeMap> edges_;
  Eigen::MatrixXd corrections_;  ///< information of the corrections of all views but the first
  Eigen::MatrixXd offsets_;      ///< information of the offsets, radii
  double expected_ = 0.0;        ///< offset, radii
};

}  // namespace planar_bin_picking
