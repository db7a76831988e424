// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/grey.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace planar_bin_picking {
namespace {

/// A ramp of all levels that so many bits have.
cv::Mat ramp(int bits) {
  cv::Mat image(1, 1 << bits, CV_16U);
  for (int x = 0; x < image.cols; ++x)
    image.at<std::uint16_t>(0, x) = static_cast<std::uint16_t>(x);
  return image;
}

TEST(Grey, TheHighestBitInUseBecomesTheHighestOfEight) {
  for (const int bits : {9, 10, 12, 14, 16}) {
    const cv::Mat image = ramp(bits);
    EXPECT_EQ(bitsInUse(image), bits);
    EXPECT_EQ(levelOf(bits) * 256, 1 << bits);
    const cv::Mat eight = toEightBits(image);
    ASSERT_EQ(eight.type(), CV_8UC1);
    for (int x = 0; x < image.cols; ++x)
      ASSERT_EQ(eight.at<std::uint8_t>(0, x), x >> (bits - 8)) << bits << " bits";
  }
}

TEST(Grey, EightBitsStayAsTheyAre) {
  const cv::Mat eight(3, 4, CV_8U, cv::Scalar(7));
  EXPECT_EQ(toEightBits(eight).data, eight.data);
  EXPECT_EQ(bitsInUse(eight), 8);
  const cv::Mat dark(3, 4, CV_16U, cv::Scalar(200));
  EXPECT_EQ(bitsInUse(dark), 8);
  EXPECT_EQ(toEightBits(dark).at<std::uint8_t>(1, 1), 200);
}

}  // namespace
}  // namespace planar_bin_picking
