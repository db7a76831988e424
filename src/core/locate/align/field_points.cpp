// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/align/field_points.h"

#include "base/simd.h"
#include "image/posed_point.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr int kMost = FieldBlock::kMost;

/// A pose in plain numbers: the axes of its plane and its translation.
struct PlaneAxes {
  double xx, xy, xz, yx, yy, yz, tx, ty, tz;
};

/// The field's geometry, and the limits within which a point is looked at.
struct Frame {
  double focal, cx, cy;
  double least, most_u, most_v, nearest;
  int pitch;
};

}  // namespace

FieldPoints::FieldPoints(const std::vector<LocalPoint>& points)
    : count(static_cast<int>(points.size())) {
  for (int i = 0; i < (count + kLanes - 1) / kLanes * kLanes; ++i) {
    const LocalPoint& p = points[std::min(i, count - 1)];
    x.push_back(p.x);
    y.push_back(p.y);
    tx.push_back(p.tx);
    ty.push_back(p.ty);
  }
}

/// @param x, y  of `n` points, of which `real` are no filling
PBP_SIMD
static void place(const Frame& frame_at, const PlaneAxes& axes, double radius, const double* x,
                  const double* y, int n, int real, FieldBlock* out) {
  const Frame frame = frame_at;  // of their own, so that no store below can change them
  const PlaneAxes T = axes;
  // Limits are variables and every choice is one of two values, else the compiler makes branches.
  for (int k = 0; k < n; ++k) {
    const double px = radius * x[k], py = radius * y[k];
    const double qx = T.tx + px * T.xx + py * T.yx, qy = T.ty + px * T.xy + py * T.yy;
    const double qz = T.tz + px * T.xz + py * T.yz;
    const double depth = qz > frame.nearest ? qz : frame.nearest, inv_z = 1.0 / depth;
    const double iu = qx * inv_z, iv = qy * inv_z;
    const double u = frame.focal * iu + frame.cx, v = frame.focal * iv + frame.cy;
    const double u_above = u > frame.least ? u : frame.least;
    const double v_above = v > frame.least ? v : frame.least;
    const double u_inside = u_above < frame.most_u ? u_above : frame.most_u;
    const double v_inside = v_above < frame.most_v ? v_above : frame.most_v;
    const int column = static_cast<int>(u_inside), row = static_cast<int>(v_inside);
    const bool is_inside = (qz > frame.nearest) & (u >= frame.least) & (v >= frame.least) &
                           (u < frame.most_u) & (v < frame.most_v);
    out->is_inside[k] = is_inside ? 1.0 : 0.0;
    out->iu[k] = iu;
    out->iv[k] = iv;
    out->inv_z[k] = inv_z;
    out->a[k] = u_inside - static_cast<double>(column);
    out->b[k] = v_inside - static_cast<double>(row);
    out->place[k] = (row * frame.pitch + column) * kDirections;
  }
  for (int k = 0; k < n; ++k) out->is_real[k] = k < real ? 1.0 : 0.0;
  for (int k = 0; k < n; ++k) out->is_inside[k] *= out->is_real[k];
}

PBP_SIMD
static void findBins(const PlaneAxes& axes, const double* tx, const double* ty, int n,
                     FieldBlock* out) {
  const PlaneAxes T = axes;
  for (int k = 0; k < n; ++k) {
    const double dz = tx[k] * T.xz + ty[k] * T.yz;
    const double along_x = tx[k] * T.xx + ty[k] * T.yx - out->iu[k] * dz;
    const double along_y = tx[k] * T.xy + ty[k] * T.yy - out->iv[k] * dz;
    out->bin[k] = directionBin(along_y, -along_x);
  }
}

/// Bilinear.
PBP_SIMD
static void sample(const std::uint8_t* distance, int pitch, int n, FieldBlock* out) {
  std::array<int, kMost> near;  // the distances at a pixel and its three neighbours, a byte each
  for (int k = 0; k < n; ++k) {
    const std::uint8_t* const p = distance + out->place[k] + out->bin[k];
    const std::uint8_t* const q = p + pitch;
    near[k] = p[0] | p[kDirections] << 8 | q[0] << 16 | q[kDirections] << 24;
  }
  constexpr double kUnit = 1.0 / kUnitsPerFieldPixel;
  for (int k = 0; k < n; ++k) {
    const double p0 = static_cast<double>(near[k] & 255),
                 p1 = static_cast<double>(near[k] >> 8 & 255);
    const double q0 = static_cast<double>(near[k] >> 16 & 255);
    const double q1 = static_cast<double>(near[k] >> 24 & 255);
    const double a = out->a[k], b = out->b[k];
    const double p = p0 + a * (p1 - p0), q = q0 + a * (q1 - q0);
    out->d[k] = kUnit * (p + b * (q - p));
    out->gx[k] = kUnit * ((p1 - p0) + b * ((q1 - q0) - (p1 - p0)));
    out->gy[k] = kUnit * (q - p);
  }
}

void look(const Field& field, const FieldPoints& points, double radius,
          const Eigen::Isometry3d& T_camera_centre, int block, bool renew_bins, FieldBlock* out) {
  const int first = block * kMost, all = static_cast<int>(points.x.size());
  const int n = std::min(kMost, all - first);
  const Eigen::Matrix3d R = T_camera_centre.linear();
  const Eigen::Vector3d t = T_camera_centre.translation();
  const PlaneAxes axes{R(0, 0), R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1), t.x(), t.y(), t.z()};
  const auto focal = field.focal;
  // A hair before the last pixel: there is one to its right and one below.
  const auto before = [](int size) { return std::nextafter(static_cast<double>(size - 1), 0.0); };
  const Frame frame{
      focal,       field.cx,   field.cy, 0.0, before(field.width), before(field.height),
      kDepthLeast, field.width};
  out->count = n;
  place(frame, axes, radius, &points.x[first], &points.y[first], n, points.count - first, out);
  if (renew_bins) findBins(axes, &points.tx[first], &points.ty[first], n, out);
  sample(field.distance.data(), field.width * kDirections, n, out);
}

}  // namespace planar_bin_picking
