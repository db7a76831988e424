// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Optional stage between refinement and score: parts that lie in a single layer on a plane that is
/// known, such as a conveyor's belt. A picture tells depth and tilt worst, and the plane says both.
///
/// The plane is what the parts lie on. A part lies flat, so its visible face, whichever it is, is
/// parallel to the plane and one thickness above it; of a part whose thickness is not given (0),
/// the plane has to be that of its visible face. Each pose is fused with this knowledge by its
/// covariance (a Kalman update of depth and two tilts, iterated since turns are not linear). What
/// lies on another part is off the plane and dropped.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/part/part_model.h"

#include <memory>
#include <optional>
#include <vector>

namespace planar_bin_picking {

/// @return  nothing where params.distance is 0
std::optional<Plane> planeOf(const PlaneParams& params);

/// Where faces that lie flat on the plane can be seen in the image, within the distances given.
/// @return  nothing where they lie outside of these
std::optional<Distances> distancesOnPlane(const Camera& camera, const Plane& plane,
                                          double thickness, const Distances& within,
                                          const PlaneParams& params);

/// @param pose  its covariance is about the centre of the visible face, as refineCandidates gives
/// it
/// @return      pose and covariance that agree with the plane; nothing where the pose is more than
///              params.gate sigmas (of pose and plane together) off it
std::optional<RefinedPose> fuseWithPlane(const RefinedPose& pose, const PartModel& part,
                                         const Plane& plane, const PlaneParams& params);

/// @param parts  those that RefinedPose::part indexes
/// @return       the poses that lie on the plane, in the same order
std::vector<RefinedPose> fuseWithPlane(const std::vector<RefinedPose>& poses,
                                       const std::vector<std::shared_ptr<const PartModel>>& parts,
                                       const Plane& plane, const PlaneParams& params);

}  // namespace planar_bin_picking
