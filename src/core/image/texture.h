// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include <algorithm>

namespace planar_bin_picking {

/// How strong the gradient is about a pixel of the image, contours left out: brushed or rolled
/// metal has gradients far above the noise everywhere.
class Texture {
 public:
  /// Cost: half a gradient filter's.
  Texture(const cv::Mat& grey, int threads);

  /// Scharr's response, grey levels times 32.
  float at(int x, int y) const {
    return level_(std::min(y / kBlock, level_.rows - 1), std::min(x / kBlock, level_.cols - 1));
  }

 private:
  static constexpr int kBlock = 8;  // pixels
  cv::Mat_<float> level_;
};

}  // namespace planar_bin_picking
