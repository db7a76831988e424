// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The plane that parts lie on, from a frame that tf knows, and whether parts on it can be where
/// they are looked for.

#include "locator/settings/cell_params.h"
#include "planar_bin_picking/locate/locator.h"

#include <Eigen/Geometry>

#include <string>

namespace planar_bin_picking_ros {

/// @throws std::invalid_argument  both parameter trees name a plane
void checkOnePlane(const CellParams& cell, const planar_bin_picking::PlaneParams& params);

/// @return  z = 0 of the frame, whichever way its z points
/// @throws Refusal  BAD_PLANE: the camera lies in the plane or looks along it
planar_bin_picking::Plane planeOfFrame(const std::string& frame,
                                       const Eigen::Isometry3d& T_camera_frame);

/// @throws Refusal  BAD_PLANE: parts on the request's plane would lie outside of its distances
void checkPlane(const planar_bin_picking::LocateRequest& request,
                const planar_bin_picking::Camera& camera,
                const planar_bin_picking::PlaneParams& params);

}  // namespace planar_bin_picking_ros
