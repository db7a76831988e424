// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "part/outline_view.h"
#include "planar_bin_picking/image/camera.h"

namespace planar_bin_picking {

inline constexpr double kDepthLeast = 1e-6;  ///< metres: nearer, no point is in front of a camera

/// A point in the image, its outward normal there and what a step of the pose does along it.
struct PosedPoint {
  Eigen::Vector2d pixel, normal;
  Eigen::Vector3d g_local;  // d(normal . pixel) / d(point), part axes, point in radii
  double out_px;            // pixels along the normal for a radius out of the material
  double deep_px;           // pixels along the normal for a radius along z of the centre frame
};

/// @return  false where the point is not in front of the camera
inline bool posePoint(const Camera& camera, const LocalPoint& p, double radius,
                      const Eigen::Isometry3d& T, PosedPoint* out) {
  const Eigen::Vector3d x = T.linear().col(0), y = T.linear().col(1);
  const Eigen::Vector3d q = T.translation() + radius * (p.x * x + p.y * y);
  if (q.z() <= kDepthLeast) return false;
  const double inv_z = 1.0 / q.z(), u = q.x() * inv_z, v = q.y() * inv_z;
  Eigen::Matrix2d lens;
  out->pixel = camera.distort({u, v}, &lens);
  const Eigen::Vector3d along = p.tx * x + p.ty * y, out_of = p.ty * x - p.tx * y;
  const auto seen = [&](const Eigen::Vector3d& d) -> Eigen::Vector2d {
    return lens * Eigen::Vector2d(d.x() - u * d.z(), d.y() - v * d.z());
  };
  const Eigen::Vector2d t = seen(along), o = seen(out_of);
  out->normal = Eigen::Vector2d(t.y(), -t.x()).normalized();
  if (out->normal.dot(o) < 0.0) out->normal = -out->normal;
  const Eigen::Vector2d n_ideal = lens.transpose() * out->normal;
  out->g_local = T.linear().transpose() *
                 (radius * inv_z *
                  Eigen::Vector3d(n_ideal.x(), n_ideal.y(), -(n_ideal.x() * u + n_ideal.y() * v)));
  out->out_px = out->normal.dot(o) * radius * inv_z;
  out->deep_px = out->normal.dot(seen(T.linear().col(2))) * radius * inv_z;
  return true;
}

/// d(normal . pixel) / d(xi), xi in radii and radians.
inline Vector6d normalJacobian(const LocalPoint& p, const PosedPoint& at) {
  return pointJacobian(p, at.g_local);
}

}  // namespace planar_bin_picking
