// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a camera makes of its pixels before the picture leaves it: the colour filters of a colour
/// camera and their demosaicing, and JPEG. The picture is grey before and after; its noise then
/// hangs together from pixel to pixel, or from block to block, as in pictures of such cameras.

#include <opencv2/core/mat.hpp>

#include <string>

namespace planar_bin_picking::cell {

struct Encoding {
  /// The colours of the first two pixels of the first row and of the second: RGGB, GRBG, GBRG or
  /// BGGR; empty = a grey camera.
  std::string bayer;
  int jpeg_quality = 0;  ///< 1 .. 100, as OpenCV's; 0 = no JPEG
};

/// @throws std::invalid_argument  another pattern, or a quality out of range
void check(const Encoding& encoding);

/// Share of white light that the filter over a pixel lets through, in units of the green one's.
double filterShare(const Encoding& encoding, int x, int y);

/// @param pixels  8 bit, as the sensor has them, each colour already multiplied to look white
/// @return        8 bit, grey
/// @throws std::invalid_argument  as check
cv::Mat encode(const cv::Mat& pixels, const Encoding& encoding);

}  // namespace planar_bin_picking::cell
