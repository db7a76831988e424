// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part that lies flat on a plane, as a prior on the pose of its visible face.

#include "locate/prior/linear_prior.h"
#include "planar_bin_picking/part/part_model.h"

namespace planar_bin_picking {

/// How far a face is off where it would lie flat: its height, metres, and the plane's normal along
/// the face's x and y, radians. By xi in T_camera_face * exp(xi).
/// @param variances  of these three
LinearPrior<6, 3> flatOn(const Plane& plane, const Eigen::Isometry3d& T_camera_face,
                         double thickness, const Eigen::Vector3d& variances);

/// Pose and covariance with that prior; iterated, since turns are not linear.
/// @param pose  its covariance is about the centre of the visible face, as refineCandidates gives
///              it
RefinedPose fuseFlat(const RefinedPose& pose, const PartModel& part, const Plane& plane,
                     const Eigen::Vector3d& variances);

}  // namespace planar_bin_picking
