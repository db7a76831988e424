// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// What colour filters and JPEG do to a picture: to its noise above all.

#include "sim/encoding.h"

#include "sim/picture.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include <cmath>

namespace planar_bin_picking::cell {
namespace {

constexpr int kSide = 160;
constexpr double kSeconds = 0.01;

/// An even surface, so that all that differs is noise.
cv::Mat evenPicture(const Encoding& encoding, std::uint64_t seed) {
  const cv::Mat_<float> light(kSide, kSide, 0.4f);
  Sensor sensor;
  sensor.encoding = encoding;
  return expose(light, sensor, kSeconds, seed);
}

/// Correlation of the noise of pixels that far apart along a row.
double noiseCorrelation(const Encoding& encoding, int apart) {
  cv::Mat noise;
  evenPicture(encoding, 3).convertTo(noise, CV_64F);
  noise -= cv::mean(noise)[0];
  const int last = kSide - apart;
  return noise.colRange(0, last).dot(noise.colRange(apart, kSide)) /
         std::sqrt(noise.colRange(0, last).dot(noise.colRange(0, last)) *
                   noise.colRange(apart, kSide).dot(noise.colRange(apart, kSide)));
}

/// Steps between neighbours at the borders of blocks of 8 pixels over those elsewhere.
double blockiness(const cv::Mat& picture) {
  double border = 0.0, inside = 0.0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 1; x < picture.cols; ++x) {
      const double step = std::abs(static_cast<double>(picture.at<std::uint8_t>(y, x)) -
                                   picture.at<std::uint8_t>(y, x - 1));
      (x % 8 == 0 ? border : inside) += step;
    }
  }
  return 7.0 * border / inside;
}

TEST(Encode, GreyCamerasNoiseIsThatOfEachPixel) {
  EXPECT_NEAR(noiseCorrelation({}, 1), 0.0, 0.05);
  EXPECT_NEAR(blockiness(evenPicture({}, 1)), 1.0, 0.05);
}

TEST(Encode, DemosaicedNoiseHangsTogetherNearBy) {
  // Bilinear: neighbours share what they are interpolated from; four pixels apart share nothing.
  for (const char* bayer : {"RGGB", "GRBG", "GBRG", "BGGR"}) {
    EXPECT_GT(noiseCorrelation({bayer, 0}, 1), 0.3) << bayer;
    EXPECT_NEAR(noiseCorrelation({bayer, 0}, 4), 0.0, 0.05) << bayer;
    EXPECT_NEAR(cv::mean(evenPicture({bayer, 0}, 1))[0], cv::mean(evenPicture({}, 1))[0], 0.5);
  }
}

TEST(Encode, TakesColoursFromWhereThePatternHasThem) {
  const struct {
    const char* bayer;
    int x, y;  // of the first red pixel
  } kCases[] = {{"RGGB", 0, 0}, {"GRBG", 1, 0}, {"GBRG", 0, 1}, {"BGGR", 1, 1}};
  constexpr double kRedInGrey = 0.299, kLevel = 200.0;
  for (const auto& c : kCases) {
    cv::Mat_<std::uint8_t> pixels(16, 16, std::uint8_t{0});
    for (int y = c.y; y < 16; y += 2)
      for (int x = c.x; x < 16; x += 2) pixels(y, x) = 200;
    EXPECT_NEAR(encode(pixels, {c.bayer, 0}).at<std::uint8_t>(8, 8), kRedInGrey * kLevel, 1.0)
        << c.bayer;
    // Red lets the least but blue through, wherever it is.
    EXPECT_LT(filterShare({c.bayer, 0}, c.x, c.y), 1.0) << c.bayer;
    EXPECT_EQ(filterShare({c.bayer, 0}, c.x + 1, c.y), 1.0) << c.bayer;
  }
}

TEST(Encode, JpegLeavesBlocksTheMoreTheLowerItsQuality) {
  const double at_90 = blockiness(evenPicture({"", 90}, 1));
  const double at_60 = blockiness(evenPicture({"", 60}, 1));
  EXPECT_GT(at_90, 1.1);  // 1 without JPEG
  EXPECT_GT(at_60, 1.5 * at_90);
}

TEST(Encode, JpegComesAfterDemosaicing) {
  const cv::Mat once = evenPicture({"RGGB", 70}, 1);
  EXPECT_GT(blockiness(once), 1.15);
  // What was JPEG of that quality is hardly changed by the same again; a demosaiced one is.
  EXPECT_LT(cv::norm(once, encode(once, {"", 70}), cv::NORM_L1) / (kSide * kSide), 0.1);
  const cv::Mat raw = evenPicture({"RGGB", 0}, 1);
  EXPECT_GT(cv::norm(raw, encode(raw, {"", 70}), cv::NORM_L1) / (kSide * kSide), 0.5);
}

TEST(Encode, RefusesWhatItDoesNotKnow) {
  const auto messageOf = [](const Encoding& encoding) {
    try {
      check(encoding);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(messageOf({}), "");
  EXPECT_EQ(messageOf({"BGGR", 100}), "");
  EXPECT_EQ(messageOf({"RGBG", 0}),
            "bayer is 'RGBG': must be RGGB, GRBG, GBRG or BGGR, or empty for a grey camera");
  for (const int quality : {-1, 101}) {
    EXPECT_EQ(messageOf({"", quality}), "jpeg_quality is " + std::to_string(quality) +
                                            ": must lie in 1 .. 100, or be 0 for no JPEG");
    EXPECT_THROW(encode(cv::Mat(8, 8, CV_8U, cv::Scalar(0)), {"", quality}), std::invalid_argument);
  }
}

}  // namespace
}  // namespace planar_bin_picking::cell
