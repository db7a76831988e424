// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What is left of the image for the later stages: a directional distance field, and the grey image
/// itself for the last, sub-pixel step.
///
/// The field lies in the ideal (undistorted) image plane, so that voting and coarse refinement need
/// no lens model. For each pixel and each of 16 edge directions it holds the distance to the
/// nearest edgel of about that direction (the directional chamfer distance of [2]).

#include "planar_bin_picking/base/types.h"

#include <opencv2/core/mat.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace planar_bin_picking {

inline constexpr int kDirections = 16;         ///< bins of the edge normal's angle over 180 degrees
inline constexpr int kUnitsPerFieldPixel = 3;  ///< chamfer weights 3 (side) and 4 (corner)
inline constexpr int kFarDistance = 120;       ///< units; nothing within 40 field pixels

/// Bin of a normal's direction, sign ignored; exact to 0.3 degrees. Without branches, for loops of
/// which the compiler takes several at once.
template <class T>
inline int directionBin(T nx, T ny) {
  static_assert((kDirections & (kDirections - 1)) == 0, "a power of two");
  constexpr T kQuarter = kDirections / 2, kLeast = std::numeric_limits<T>::min();
  const T x = std::abs(nx), y = std::abs(ny), apart = std::abs(x - y);
  const T q = (x + y - apart) / (x + y + apart + kLeast);  // the smaller over the larger
  const T octant = q * (T(0.97239411) - T(0.19194795) * q * q) * T(kDirections / M_PI);  // atan(q)
  const T half = kQuarter / 2, quadrant = half + std::copysign(half - octant, y - x);
  const T side = std::copysign(T(1), nx) * std::copysign(T(1), ny);
  const T turns = kQuarter + side * (quadrant - kQuarter);
  return static_cast<int>(turns + T(0.5)) & (kDirections - 1);
}

/// u = focal * x/z + cx, v = focal * y/z + cy; pixel (0, 0) is the centre of the first field pixel.
struct Field {
  int width = 0, height = 0;
  double focal = 0.0, cx = 0.0, cy = 0.0;  ///< field pixels
  double image_px = 0.0;                   ///< size of a field pixel in image pixels
  std::vector<std::uint8_t> distance;      ///< [height][width][kDirections], kUnitsPerFieldPixel

  const std::uint8_t* at(int x, int y) const {
    return distance.data() + (static_cast<std::size_t>(y) * width + x) * kDirections;
  }
};

struct EdgeMap {
  std::vector<Field> fields;          ///< one for each scale that the parts need
  std::vector<std::size_t> field_of;  ///< by part: index into the fields
  cv::Mat image;                      ///< 8 bit; the caller's own where that has 8 bits, not copied
  std::size_t edgels = 0;
  /// Standard deviation of the image's noise by grey level (256 steps of the full range), grey
  /// levels.
  std::array<float, 256> noise{};

  const Field& fieldOf(std::size_t part) const { return fields[field_of[part]]; }
};

}  // namespace planar_bin_picking
