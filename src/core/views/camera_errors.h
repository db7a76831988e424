// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How wrong the cameras' places may be, of all views together.
///
/// T_first_view follows from the robot's pose at either picture and the hand-eye transform X:
/// X^-1 F_first^-1 F_view X. An error of X is the same in all views and cancels where the camera is
/// only shifted; one of the robot's is another at each stop. Both act on the right (se3.h).

#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/locate/params.h"

#include <vector>

namespace planar_bin_picking {

/// How xi of T * exp(xi) moves when it is taken to the other side: T exp(xi) = exp(adjoint xi) T.
Matrix6d adjoint(const Eigen::Isometry3d& T);

/// Covariance of the corrections c of all views but the first, T_first_view * exp(c), six each;
/// metres and radians.
/// @param focal_px  a part of a pixel by which all edges of a view are off alike is a turn, too
Eigen::MatrixXd correctionCovariance(const std::vector<Eigen::Isometry3d>& T_first_view,
                                     const ViewsParams& params, double focal_px);

}  // namespace planar_bin_picking
