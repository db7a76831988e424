// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The simulated camera's lens: plumb_bob, written once more, so that the localizer's projection
/// has something to be wrong against. Pixel (0, 0) is the centre of the top-left pixel.

#include <Eigen/Core>

#include <array>

namespace planar_bin_picking::cell {

struct Lens {
  int width = 1280, height = 1024;
  double fx = 1700.0, fy = 1700.0, cx = 640.0, cy = 512.0;
  std::array<double, 5> d = {0.0, 0.0, 0.0, 0.0, 0.0};  ///< k1 k2 p1 p2 k3
};

/// A point x / z, y / z as the lens moves it.
inline Eigen::Vector2d bend(const Lens& lens, const Eigen::Vector2d& p) {
  const auto& [k1, k2, p1, p2, k3] = lens.d;
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y)};
}

inline Eigen::Vector2d pixelOf(const Lens& lens, const Eigen::Vector3d& x_camera) {
  const Eigen::Vector2d p = bend(lens, x_camera.head<2>() / x_camera.z());
  return {lens.fx * p.x() + lens.cx, lens.fy * p.y() + lens.cy};
}

/// The ray through a pixel, with z = 1, in the camera frame.
inline Eigen::Vector3d rayOf(const Lens& lens, double u, double v) {
  const Eigen::Vector2d seen((u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy);
  Eigen::Vector2d p = seen;
  // A fixed point; each step shrinks the error by about the size of the distortion.
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d step = seen - bend(lens, p);
    p += step;
    if (step.squaredNorm() < 1e-24) break;
  }
  return {p.x(), p.y(), 1.0};
}

}  // namespace planar_bin_picking::cell
