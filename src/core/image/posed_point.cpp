// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/posed_point.h"

#include "base/simd.h"

namespace planar_bin_picking {
namespace {

constexpr int kLanes = PosedPoints::kLanes;
using Lanes = PosedPoints::Lanes;
constexpr double kTiny = 1e-300;  // against a division by zero

/// A pose in plain numbers: its axes and its translation.
struct Axes {
  double xx, xy, xz, yx, yy, yz, zx, zy, zz, tx, ty, tz;
};

/// Points of an outline, as in LocalPoint.
struct LocalLanes {
  Lanes x, y, tx, ty;
};

}  // namespace

PBP_SIMD
static void pose(const Lens& lens_at, const Axes& axes, double radius, const LocalLanes& points,
                 PosedPoints* out) {
  const Lens lens = lens_at;  // of its own, so that no store below can change it
  const Axes T = axes;
  Lanes depth;
  for (int k = 0; k < kLanes; ++k) {
    const double px = radius * points.x[k], py = radius * points.y[k];
    const double qx = T.tx + px * T.xx + py * T.yx, qy = T.ty + px * T.xy + py * T.yy;
    depth[k] = T.tz + px * T.xz + py * T.yz;
    const double inv_z = 1.0 / depth[k], u = qx * inv_z, v = qy * inv_z;
    const Lens::Pixel pixel = lens.distort(u, v);
    const double tx = points.tx[k], ty = points.ty[k], az = tx * T.xz + ty * T.yz;
    const double ax = tx * T.xx + ty * T.yx - u * az, ay = tx * T.xy + ty * T.yy - v * az;
    // The normal is the seen tangent turned by a right angle, to whichever side leads outward.
    const double along_x = pixel.xx * ax + pixel.xy * ay, along_y = pixel.yx * ax + pixel.yy * ay;
    const double share = 1.0 / std::sqrt(along_x * along_x + along_y * along_y + kTiny);
    const double nx = share * along_y, ny = -share * along_x;
    const double ix = radius * inv_z * (pixel.xx * nx + pixel.yx * ny);
    const double iy = radius * inv_z * (pixel.xy * nx + pixel.yy * ny);
    const double iz = -(ix * u + iy * v);
    const double gx = T.xx * ix + T.xy * iy + T.xz * iz, gy = T.yx * ix + T.yy * iy + T.yz * iz;
    const double gz = T.zx * ix + T.zy * iy + T.zz * iz, out_px = ty * gx - tx * gy;
    const double sign = std::copysign(1.0, out_px);
    out->x[k] = pixel.x;
    out->y[k] = pixel.y;
    out->nx[k] = sign * nx;
    out->ny[k] = sign * ny;
    out->gx[k] = sign * gx;
    out->gy[k] = sign * gy;
    out->gz[k] = sign * gz;
    out->out_px[k] = sign * out_px;
  }
  for (int k = 0; k < kLanes; ++k) out->is_in_front[k] = depth[k] > kDepthLeast;
}

static Axes axesOf(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d& R = T.linear();
  const Eigen::Vector3d& t = T.translation();
  return {R(0, 0), R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1),
          R(0, 2), R(1, 2), R(2, 2), t.x(),   t.y(),   t.z()};
}

/// The points from `points` on; where there are fewer than lanes, the last one fills the rest.
static void posePoints(const Camera& camera, const LocalPoint* points, int count, double radius,
                       const Axes& axes, PosedPoints* out) {
  LocalLanes lanes;
  for (int k = 0; k < kLanes; ++k) {
    const LocalPoint& p = points[std::min(k, count - 1)];
    lanes.x[k] = p.x;
    lanes.y[k] = p.y;
    lanes.tx[k] = p.tx;
    lanes.ty[k] = p.ty;
  }
  pose(camera.lens(), axes, radius, lanes, out);
}

std::vector<PosedPoints> posePoints(const Camera& camera, const std::vector<LocalPoint>& points,
                                    double radius, const Eigen::Isometry3d& T_camera_centre) {
  const Axes axes = axesOf(T_camera_centre);
  const int n = static_cast<int>(points.size());
  std::vector<PosedPoints> out(static_cast<std::size_t>((n + kLanes - 1) / kLanes));
  for (int i = 0; i < n; i += kLanes)
    posePoints(camera, &points[i], n - i, radius, axes, &out[i / kLanes]);
  return out;
}

bool posePoint(const Camera& camera, const LocalPoint& p, double radius, const Eigen::Isometry3d& T,
               PosedPoint* out) {
  PosedPoints lanes;
  posePoints(camera, &p, 1, radius, axesOf(T), &lanes);
  *out = lanes.at(0);
  return lanes.is_in_front[0];
}

}  // namespace planar_bin_picking
