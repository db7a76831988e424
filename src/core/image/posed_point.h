// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "part/outline_view.h"
#include "planar_bin_picking/image/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace planar_bin_picking {

inline constexpr double kDepthLeast = 1e-6;  ///< metres: nearer, no point is in front of a camera

/// A point in the image, its outward normal there and what a step of the pose does along it.
struct PosedPoint {
  Eigen::Vector2d pixel, normal;
  Eigen::Vector3d g_local;  // d(normal . pixel) / d(point), part axes, point in radii
  double out_px;            // pixels along the normal for a radius out of the material
  double deep_px;           // pixels along the normal for a radius along z of the centre frame
};

/// Points of an outline one after the other by component: the compiler takes several at once.
struct PosedPoints {
  static constexpr int kLanes = 16;
  using Lanes = std::array<double, kLanes>;
  Lanes x, y, nx, ny, gx, gy, gz, out_px;  // as PosedPoint; deep_px is gz
  std::array<bool, kLanes> is_in_front;

  PosedPoint at(int k) const {
    return {{x[k], y[k]}, {nx[k], ny[k]}, {gx[k], gy[k], gz[k]}, out_px[k], gz[k]};
  }
};

/// All of the points, kLanes to a block; the last point fills the rest of the last block.
std::vector<PosedPoints> posePoints(const Camera& camera, const std::vector<LocalPoint>& points,
                                    double radius, const Eigen::Isometry3d& T_camera_centre);

/// Point i of them.
/// @return  false where it is not in front of the camera
inline bool pointAt(const std::vector<PosedPoints>& points, std::size_t i, PosedPoint* out) {
  const PosedPoints& block = points[i / PosedPoints::kLanes];
  const int lane = static_cast<int>(i % PosedPoints::kLanes);
  *out = block.at(lane);
  return block.is_in_front[lane];
}

/// The same of one point alone.
bool posePoint(const Camera& camera, const LocalPoint& p, double radius, const Eigen::Isometry3d& T,
               PosedPoint* out);

/// d(normal . pixel) / d(xi), xi in radii and radians.
inline Vector6d normalJacobian(const LocalPoint& p, const PosedPoint& at) {
  return pointJacobian(p, at.g_local);
}

}  // namespace planar_bin_picking
