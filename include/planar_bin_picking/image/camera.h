// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The camera with its full lens model: plumb_bob (5 coefficients) and rational_polynomial (8).
/// Immutable; every member function is safe to call from several threads.

#include "planar_bin_picking/base/types.h"

#include <array>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// The lens in plain numbers, for loops of which the compiler takes several points at once.
struct Lens {
  /// A pixel, and its derivatives by the ideal point: xy of its x by the point's y.
  struct Pixel {
    double x, y, xx, xy, yx, yy;
  };
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0, k4 = 0.0, k5 = 0.0, k6 = 0.0;

  Pixel distort(double x, double y) const {
    const double r2 = x * x + y * y;
    const double above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double inv_below = 1.0 / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
    const double radial = above * inv_below;
    const double xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
    const double yd = y * radial + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y);
    const double above_r2 = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
    const double below_r2 = k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6);
    const double radial_r2 = (above_r2 - radial * below_r2) * inv_below;
    const double mixed = 2.0 * (x * y * radial_r2 + p1 * x + p2 * y);
    return {fx * xd + cx,
            fy * yd + cy,
            fx * (radial + 2.0 * x * x * radial_r2 + 2.0 * p1 * y + 6.0 * p2 * x),
            fx * mixed,
            fy * mixed,
            fy * (radial + 2.0 * y * y * radial_r2 + 6.0 * p1 * y + 2.0 * p2 * x)};
  }
};

class Camera {
 public:
  struct Model {
    int width = 0, height = 0;                      ///< pixels
    double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< pixels
    std::string distortion_model = "plumb_bob";     ///< or rational_polynomial; "" = no distortion
    std::vector<double> distortion;  ///< k1 k2 p1 p2 k3 [k4 k5 k6]; empty or shorter = 0
  };

  /// @throws std::invalid_argument  naming the field, its value and what it must be: size <= 0; fx
  ///         or fy not > 0, both 1 (no calibration), or more than 20 % apart; a field of view
  ///         outside 2 .. 150 degrees; a principal point outside the image; unknown lens model, too
  ///         many coefficients; a lens model that folds over inside the image or bends its border
  ///         by more than a factor of 4
  explicit Camera(const Model& model);

  const Model& model() const { return model_; }
  const Lens& lens() const { return lens_; }

  /// Ideal (undistorted) image-plane point x/z, y/z -> pixel.
  Eigen::Vector2d distort(const Eigen::Vector2d& p_ideal) const;
  /// The same, with the 2x2 Jacobian of the pixel by the ideal point.
  Eigen::Vector2d distort(const Eigen::Vector2d& p_ideal, Eigen::Matrix2d* jacobian) const;
  /// Pixel -> ideal image-plane point (x/z, y/z). Newton; exact to 1e-9 px inside the image.
  Eigen::Vector2d undistort(const Eigen::Vector2d& p_image) const;
  /// Point in front of the camera -> pixel. @pre z > 0
  Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const;

 private:
  Model model_;
  Lens lens_;
};

/// The model, without distortion, of a camera matrix, row by row, as messages and files have it.
/// @throws std::invalid_argument  not [fx, 0, cx, 0, fy, cy, 0, 0, 1], such as one with a skew
Camera::Model pinholeModel(int width, int height, const std::array<double, 9>& K);

}  // namespace planar_bin_picking
