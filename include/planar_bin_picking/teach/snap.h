// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Moves of a pick pose to where a person most often wants it. Each leaves alone what it is not
/// about.

#include "planar_bin_picking/drawing/drawing.h"
#include "planar_bin_picking/part/pick_poses.h"

#include <optional>

namespace planar_bin_picking {

/// The face that a pose is for; the front where it is for any.
Face faceFor(const PickPose& pose);

/// Upright on its face: z along the normal into the part, turned the least, and the contact on the
/// face, at the place where the tool's axis meets it.
PickPose snappedToNormal(PickPose pose, double thickness);

/// The contact over the centroid of the material, that is, of the outline without its holes.
PickPose snappedToCentroid(PickPose pose, const Drawing& drawing);

/// The contact over the middle of the nearest hole; nothing where the part has none.
std::optional<PickPose> snappedToHole(PickPose pose, const Drawing& drawing);

/// @param angle  rad, about the pose's own z
PickPose turned(PickPose pose, double angle);

/// The same for the other face: the same place, depth below the face and x axis.
PickPose forOtherFace(PickPose pose, double thickness);

}  // namespace planar_bin_picking
