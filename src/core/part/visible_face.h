// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Which way the face that is up looks.

#include "part/outline_view.h"
#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_model.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {

/// Radii of the part from its centre to a corner of its grid: of the square about a circle, and a
/// cell more.
inline constexpr double kGridRadii = 1.5;

/// Normal of the face that is up, out of the part: its z axis for the front.
inline Eigen::Vector3d normalOf(const Eigen::Isometry3d& T_camera_part, Face face) {
  return (face == Face::kFront ? 1.0 : -1.0) * T_camera_part.linear().col(2);
}

/// Between that normal and the way back along the optical axis, rad: up to pi where it looks away.
inline double tiltOf(const Eigen::Isometry3d& T_camera_part, Face face) {
  return std::acos(std::clamp(-normalOf(T_camera_part, face).z(), -1.0, 1.0));
}

/// Whether the camera can see the face that is said to be up: all of it and of its grid lies in
/// front of the camera, and it looks toward the camera, against the optical axis and the ray.
inline bool showsFace(const PartModel& part, const Eigen::Isometry3d& T_camera_part, Face face) {
  const Eigen::Vector3d centre = T_camera_part * centreOf(part, face).translation();
  const Eigen::Vector3d normal = normalOf(T_camera_part, face);
  const double rise = kGridRadii * part.radius() * std::hypot(normal.x(), normal.y());
  return centre.z() - rise > 0.0 && normal.z() < 0.0 && normal.dot(centre) < 0.0;
}

}  // namespace planar_bin_picking
