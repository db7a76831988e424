// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The picture that a camera takes of the cell: rays through the lens, light at what they meet,
/// then the sensor. The same input gives the same bytes.
///
/// One ray per pixel finds what is seen. Soft light is gathered in cells of 2 x 2 pixels, or 4 x 4
/// in a fine picture, and shared between neighbours on the same surface; pixels at edges get nine
/// rays, so that edges are true to a small part of a pixel.

#include "sim/encoding.h"
#include "sim/lens.h"
#include "sim/light.h"
#include "sim/print_image.h"

#include <opencv2/core/mat.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace planar_bin_picking::cell {

/// What is in the picture: bodies in the raycaster's order, and how each looks.
struct Looks {
  std::vector<Material> materials;             ///< by body
  std::vector<Eigen::Isometry3d> T_body_base;  ///< by body: where its pattern sticks
  std::vector<std::uint32_t> seeds;            ///< by body
  std::vector<const PrintImage*> prints{};     ///< by body, as far as it goes; null = none
};

class Eye {
 public:
  explicit Eye(const Lens& lens);

  /// Light per pixel, linear, without noise; about 0.3 on a bright part under its lamp.
  cv::Mat_<float> look(const Raycaster& world, const Looks& looks, const Lamps& lamps,
                       const Eigen::Isometry3d& T_base_camera) const;

  const Lens& lens() const { return lens_; }

 private:
  Lens lens_;
  std::vector<Eigen::Vector2f> rays_;  ///< x / z and y / z of each pixel's centre
};

struct Sensor {
  double blur_px = 0.6;             ///< of the lens, standard deviation
  double full_well = 10000.0;       ///< electrons
  double read_noise = 5.0;          ///< electrons
  double light_per_second = 100.0;  ///< 1 of light fills the well in 1 / this
  Encoding encoding{};              ///< what the camera makes of the pixels
};

/// 8 bit, linear, saturated at the full well.
cv::Mat expose(const cv::Mat_<float>& light, const Sensor& sensor, double seconds,
               std::uint64_t seed);

/// The exposure at which this share of the pixels reaches 85 % of the full well, seconds.
double exposureFor(const cv::Mat_<float>& light, const Sensor& sensor, double percentile);

}  // namespace planar_bin_picking::cell
