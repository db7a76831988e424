// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// First part of stage 3: poses settle in the directional distance field (no lens model, no image).

#include "image/edge_map.h"
#include "locate/refine/refine.h"
#include "part/outline_view.h"

#include <vector>

namespace planar_bin_picking {

struct FieldPose {
  Eigen::Isometry3d T_camera_centre;
  double support = 0.0;  ///< share of points that lie on an edgel, graded, 0..1
};

/// Levenberg-Marquardt on the truncated distances of the points ([2]), the reach shrinking as it
/// goes.
/// @param reach_px  field pixels within which an edgel attracts a point at first
FieldPose settleInField(const Field& field, const std::vector<LocalPoint>& points, double radius,
                        const Eigen::Isometry3d& T_camera_centre, double reach_px,
                        const RefineParams& params);

/// Share of the points that lie on an edgel, graded to 0 at `reach_px` field pixels.
double supportInField(const Field& field, const std::vector<LocalPoint>& points, double radius,
                      const Eigen::Isometry3d& T_camera_centre, double reach_px);

}  // namespace planar_bin_picking
