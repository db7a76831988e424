// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// First part of stage 3: poses are aligned in the directional distance field (no lens model, no
/// image).

#include "locate/align/field_points.h"
#include "planar_bin_picking/locate/params.h"

namespace planar_bin_picking {

/// Robust least squares on the points' distances ([2]); the width of Tukey's biweight shrinks as it
/// goes.
/// @param reach_px  field pixels within which an edgel attracts a point at first
/// @return          T_camera_centre
Eigen::Isometry3d alignInField(const Field& field, const FieldPoints& points, double radius,
                               const Eigen::Isometry3d& T_camera_centre, double reach_px,
                               const RefineParams& params);

/// Share of the points that lie on an edgel, graded to 0 at `reach_px` field pixels.
double fieldInlierScore(const Field& field, const FieldPoints& points, double radius,
                        const Eigen::Isometry3d& T_camera_centre, double reach_px);

}  // namespace planar_bin_picking
