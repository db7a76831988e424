// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/hdr.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Light per second from 1 to 1000 over the width, and a fine pattern of 10 % on it.
cv::Mat_<float> ramp() {
  cv::Mat_<float> light(60, 400);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x)
      light(y, x) =
          static_cast<float>(std::pow(1000.0, x / 399.0) * ((x / 10 + y / 10) % 2 ? 1.1 : 1.0));
  return light;
}

/// A camera: 1000 of light in 1 s is full scale; the noise is a share of it.
cv::Mat expose(const cv::Mat_<float>& light, double seconds, int depth = CV_8U, double noise = 0.0,
               double gamma = 1.0, int full = 255) {
  cv::Mat_<float> grey = light * (seconds / 1000.0);
  cv::Mat_<float> grain(light.size());
  cv::RNG(7).fill(grain, cv::RNG::NORMAL, 0.0, std::max(noise, 1e-9));
  grey = cv::min(cv::max(grey + grain, 0.0f), 1.0f);
  cv::pow(grey, 1.0 / gamma, grey);
  cv::Mat out;
  grey.convertTo(out, depth, full);
  return out;
}

std::vector<Exposure> bracketOf(const cv::Mat_<float>& light) {
  std::vector<Exposure> bracket;
  for (const double seconds : {0.5, 4.0, 32.0})
    bracket.push_back({expose(light, seconds), seconds});
  return bracket;
}

HdrParams linearParams() {
  HdrParams params;
  params.white_percentile = 100.0;
  params.compression = 0.0;
  return params;
}

TEST(MergeExposures, HoldsThreeDecades) {
  const cv::Mat_<float> light = ramp();
  HdrParams params = linearParams();
  params.compression = 1000.0;
  const cv::Mat merged = mergeExposures(bracketOf(light), params, 2);
  ASSERT_EQ(merged.type(), CV_8UC1);
  ASSERT_EQ(merged.size(), light.size());
  double white = 0.0;
  cv::minMaxLoc(light, nullptr, &white);
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x) {
      const double expected = 255.0 * std::log1p(1000.0 * light(y, x) / white) / std::log1p(1000.0);
      // Half a grey level of the longest exposure where it is darkest (1 of 8), as much as the
      // curve is steep there; 0.5 for the rounding of the result.
      ASSERT_NEAR(merged.at<std::uint8_t>(y, x), expected, 3.0) << x << " " << y;
    }
  }
}

TEST(MergeExposures, OneExposureIsOnlyScaled) {
  const cv::Mat_<float> light = ramp();
  const cv::Mat image = expose(light, 0.4);  // brightest at 0.44 of full scale
  double brightest = 0.0;
  cv::minMaxLoc(image, nullptr, &brightest);
  const cv::Mat merged = mergeExposures({{image, 0.4}}, linearParams(), 1);
  cv::Mat expected;
  image.convertTo(expected, CV_8U, 255.0 / brightest);
  EXPECT_LE(cv::norm(merged, expected, cv::NORM_INF), 1.0);
}

TEST(MergeExposures, IsTheSameForAnyOrderAndThreads) {
  const cv::Mat_<float> light = ramp();
  std::vector<Exposure> bracket = bracketOf(light);
  const cv::Mat merged = mergeExposures(bracket, HdrParams(), 1);
  std::reverse(bracket.begin(), bracket.end());
  EXPECT_EQ(cv::norm(merged, mergeExposures(bracket, HdrParams(), 3), cv::NORM_INF), 0.0);
}

TEST(MergeExposures, TakesTwelveBitsAndAGamma) {
  const cv::Mat_<float> light = ramp();
  HdrParams params = linearParams();
  params.compression = 100.0;
  const cv::Mat eight = mergeExposures(bracketOf(light), params, 1);
  params.response_gamma = 2.2;
  std::vector<Exposure> bracket;
  for (const double seconds : {0.5, 4.0, 32.0})
    bracket.push_back({expose(light, seconds, CV_16U, 0.0, 2.2, 4095), seconds});
  EXPECT_LE(cv::norm(eight, mergeExposures(bracket, params, 2), cv::NORM_INF), 2.0);
}

TEST(MergeExposures, KeepsEdgesThatEachExposureLoses) {
  const cv::Mat_<float> light = ramp();
  HdrParams params = linearParams();
  params.compression = 1000.0;
  const cv::Mat merged = mergeExposures(bracketOf(light), params, 1);
  // The pattern's edge between rows 9 and 10, in the dark and in the bright end of the ramp.
  for (const int x : {65, 385}) {
    EXPECT_GE(std::abs(merged.at<std::uint8_t>(9, x) - merged.at<std::uint8_t>(10, x)), 2) << x;
  }
  const cv::Mat shortest = bracketOf(light)[0].image, longest = bracketOf(light)[2].image;
  EXPECT_EQ(shortest.at<std::uint8_t>(9, 65), shortest.at<std::uint8_t>(10, 65));
  EXPECT_EQ(longest.at<std::uint8_t>(9, 385), longest.at<std::uint8_t>(10, 385));
}

TEST(MergeExposures, RefusesWhatCannotBeMerged) {
  const cv::Mat grey(4, 5, CV_8U, cv::Scalar(9)), other(5, 4, CV_8U, cv::Scalar(9));
  EXPECT_THROW(mergeExposures({}, HdrParams(), 1), std::invalid_argument);
  EXPECT_THROW(mergeExposures({{cv::Mat(), 1.0}}, HdrParams(), 1), std::invalid_argument);
  EXPECT_THROW(mergeExposures({{grey, 1.0}, {other, 2.0}}, HdrParams(), 1), std::invalid_argument);
  EXPECT_THROW(mergeExposures({{grey, 0.0}}, HdrParams(), 1), std::invalid_argument);
  EXPECT_THROW(mergeExposures({{grey, std::nan("")}}, HdrParams(), 1), std::invalid_argument);
  EXPECT_THROW(mergeExposures({{cv::Mat(4, 5, CV_8UC3), 1.0}}, HdrParams(), 1),
               std::invalid_argument);
  HdrParams params;
  params.saturation_from = params.saturation_to;
  EXPECT_THROW(mergeExposures({{grey, 1.0}}, params, 1), std::invalid_argument);
  params = HdrParams();
  params.white_percentile = 101.0;
  try {
    validate(params);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("white_percentile is 101"), std::string::npos);
  }
}

TEST(MergeExposures, BlackImagesStayBlack) {
  const cv::Mat black(8, 8, CV_8U, cv::Scalar(0));
  EXPECT_EQ(cv::countNonZero(mergeExposures({{black, 1.0}, {black, 4.0}}, HdrParams(), 1)), 0);
}

TEST(ExposureRatio, IsFoundUnderNoiseAndSaturation) {
  const cv::Mat_<float> light = ramp();
  const cv::Mat reference = expose(light, 1.0, CV_8U, 0.004);
  for (const double ratio : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    const auto found = exposureRatio(reference, expose(light, ratio, CV_8U, 0.005), HdrParams());
    ASSERT_TRUE(found) << ratio;
    EXPECT_NEAR(*found / ratio, 1.0, 0.05) << ratio;
  }
}

TEST(ExposureRatio, FollowsTheResponse) {
  const cv::Mat_<float> light = ramp();
  HdrParams params;
  params.response_gamma = 2.2;
  const auto found = exposureRatio(expose(light, 1.0, CV_8U, 0.0, 2.2),
                                   expose(light, 4.0, CV_8U, 0.0, 2.2), params);
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, 4.0, 0.2);
}

TEST(ExposureRatio, SaysNothingWhereNoGreyLevelTells) {
  const cv::Mat dark(50, 50, CV_8U, cv::Scalar(3)), white(50, 50, CV_8U, cv::Scalar(255));
  EXPECT_FALSE(exposureRatio(dark, white, HdrParams()));
  EXPECT_FALSE(exposureRatio(white, white, HdrParams()));
}

}  // namespace
}  // namespace planar_bin_picking
