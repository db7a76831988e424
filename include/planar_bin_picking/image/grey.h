// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Grey levels of any depth as the package counts them: 0..255. The only place where 16 bits become
/// 8.

#include <opencv2/core/mat.hpp>

namespace planar_bin_picking {

/// 16-bit images carry 10, 12, 14 or 16 bits, in the low ones, and no message says how many: the
/// highest bit that the image uses.
/// @return  8 for 8-bit images, otherwise 8..16
int bitsInUse(const cv::Mat& image);

/// One grey level of 256 in an image's own levels.
inline double levelOf(int bits) { return static_cast<double>(1 << (bits - 8)); }

/// The highest bit in use becomes bit 7; an 8-bit image is returned as it is, not copied.
cv::Mat toEightBits(const cv::Mat& image);

}  // namespace planar_bin_picking
