// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What is printed or engraved on a part's front face: strokes about a drawing's centre lines.

#include "sim/shape.h"

#include <opencv2/core/mat.hpp>

namespace planar_bin_picking::cell {

class PrintImage {
 public:
  /// @param stroke  width of the lines, metres
  explicit PrintImage(const Shape& shape, double stroke = 0.001);

  bool empty() const { return cover_.empty(); }
  /// Share of ink at a point of the part, 0..1: none off the front face.
  float at(const Eigen::Vector3f& x_part) const;

 private:
  cv::Mat_<float> cover_;
  Eigen::Vector2f corner_ = Eigen::Vector2f::Zero();  ///< of the first pixel, metres
};

}  // namespace planar_bin_picking::cell
