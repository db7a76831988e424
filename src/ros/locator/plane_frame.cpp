// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/plane_frame.h"

#include "shared/refusal.h"

#include "planar_bin_picking/locate/prior/plane_prior.h"

#include <planar_bin_picking/LocatePart.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace planar_bin_picking_ros {

using planar_bin_picking::Plane;

namespace {

template <class... Values>
[[noreturn]] void refuse(const char* pattern, Values... values) {
  char message[300];
  std::snprintf(message, sizeof message, pattern, values...);
  throw Refusal(planar_bin_picking::LocatePart::Response::BAD_PLANE, message);
}

}  // namespace

void checkOnePlane(const CellParams& cell, const planar_bin_picking::PlaneParams& params) {
  if (cell.plane_frame.empty() || params.distance == 0.0) return;
  throw std::invalid_argument(
      "~cell/plane_frame and ~locator/plane/distance are both set; each says where the plane is "
      "that "
      "parts lie on: unset one");
}

Plane planeOfFrame(const std::string& frame, const Eigen::Isometry3d& T_camera_frame) {
  constexpr double kNearest = 1e-3;  // metres
  constexpr double kGrazing = 0.1;   // cosine; as far as ~locator/plane/normal_z goes
  const Eigen::Vector3d z_camera = T_camera_frame.linear().col(2);
  const double height = -z_camera.dot(T_camera_frame.translation());  // of the camera, along z
  const Plane plane{height < 0.0 ? Eigen::Vector3d(-z_camera) : z_camera, std::abs(height)};
  const double cosine = -plane.normal_camera.z();
  if (plane.distance < kNearest || cosine < kGrazing) {
    refuse(
        "the plane z = 0 of %s is %.3f m from the camera and its normal %.0f degrees off the "
        "optical axis: parts on it cannot be seen; check ~cell/plane_frame and the camera's "
        "calibration",
        frame.c_str(), plane.distance, std::acos(cosine) * 180.0 / M_PI);
  }
  return plane;
}

void checkPlane(const planar_bin_picking::LocateRequest& request,
                const planar_bin_picking::Camera& camera,
                const planar_bin_picking::PlaneParams& params) {
  const auto plane = request.plane ? request.plane : planar_bin_picking::planeOf(params);
  if (!plane) return;
  for (const auto& part : request.parts) {
    if (distancesOnPlane(camera, *plane, part->thickness(),
                         {request.distance_min, request.distance_max}, params))
      continue;
    refuse(
        "on the plane %.3f m from the camera, part '%s' would lie outside of %.3f .. %.3f m where "
        "parts are looked for; correct the plane or the distances (or the bin)",
        plane->distance, part->name().c_str(), request.distance_min, request.distance_max);
  }
}

}  // namespace planar_bin_picking_ros
