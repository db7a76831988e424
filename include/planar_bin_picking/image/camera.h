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
  std::array<double, 8> d_{};
};

/// The model, without distortion, of a camera matrix, row by row, as messages and files have it.
/// @throws std::invalid_argument  not [fx, 0, cx, 0, fy, cy, 0, 0, 1], such as one with a skew
Camera::Model pinholeModel(int width, int height, const std::array<double, 9>& K);

}  // namespace planar_bin_picking
