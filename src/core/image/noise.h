// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include <array>

namespace planar_bin_picking {

/// Noise of an 8-bit image by grey level, from small blocks: each block's median |second
/// difference| (Gaussian noise of sigma s gives 0.6745 * sqrt(6) * s), then the median of the
/// blocks of about that level. Edges fill few blocks, so they do not count; texture does, as it
/// should.
std::array<float, 256> estimateNoise(const cv::Mat& grey);

}  // namespace planar_bin_picking
