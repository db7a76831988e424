// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/grey.h"

#include <opencv2/core.hpp>

namespace planar_bin_picking {

int bitsInUse(const cv::Mat& image) {
  int bits = 8;
  if (image.depth() == CV_8U || image.empty()) return bits;
  double highest = 0.0;
  cv::minMaxLoc(image, nullptr, &highest);
  while (bits < 16 && (1 << bits) <= highest) ++bits;
  return bits;
}

cv::Mat toEightBits(const cv::Mat& image) {
  if (image.depth() == CV_8U) return image;
  const double level = levelOf(bitsInUse(image));
  cv::Mat out;
  // Each level takes in whole steps of the image's: what its lowest bits hold does not matter.
  image.convertTo(out, CV_8U, 1.0 / level, -0.5 + 0.5 / level);
  return out;
}

}  // namespace planar_bin_picking
