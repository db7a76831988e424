// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <cstddef>
#include <cstdint>

namespace planar_bin_picking {

/// Whether a profile of `span` pixels to all sides of p stays within the image.
inline bool fitsInside(const cv::Mat& image, const Eigen::Vector2d& p, double span) {
  return p.x() >= span && p.y() >= span && p.x() <= image.cols - 2 - span &&
         p.y() <= image.rows - 2 - span;
}

/// Grey levels along a straight line of unit steps, added to sum[0..n), bilinear. Fixed point: 16
/// fractional bits for the position, 8 for the weights.
/// @pre all of it lies within the image, see fitsInside
inline void addProfile(const cv::Mat& image, float x0, float y0, float dx, float dy, int n,
                       float* sum) {
  constexpr float kOne = 65536.0f;  // of 16 fractional bits
  int x = static_cast<int>(x0 * kOne), y = static_cast<int>(y0 * kOne);
  const int step_x = static_cast<int>(dx * kOne), step_y = static_cast<int>(dy * kOne);
  const std::uint8_t* const data = image.data;
  const auto row = static_cast<std::ptrdiff_t>(image.step);
  for (int k = 0; k < n; ++k, x += step_x, y += step_y) {
    const std::uint8_t* p = data + (y >> 16) * row + (x >> 16);
    const int a = (x >> 8) & 255, b = (y >> 8) & 255;
    const int top = (p[0] << 8) + a * (p[1] - p[0]);
    const int bottom = (p[row] << 8) + a * (p[row + 1] - p[row]);
    sum[k] += static_cast<float>((top << 8) + b * (bottom - top)) * (1.0f / kOne);
  }
}

}  // namespace planar_bin_picking
