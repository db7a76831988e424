// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/edges.h"

#include "support/plates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace planar_bin_picking {
namespace {

sim::PinholeCamera camera(bool lens) {
  sim::PinholeCamera out;
  out.width = 640;
  out.height = 480;
  out.fx = out.fy = 900.0;
  out.cx = 320.0;
  out.cy = 240.0;
  out.lens = {};
  if (lens) out.lens = {-0.3, 0.1, 1e-3, -1e-3, 0.0};
  return out;
}

EdgeMap edgesOf(const cv::Mat& image, const sim::PinholeCamera& from, int threads = 1) {
  return findEdges(image, makeCamera(from), {}, threads);
}

cv::Mat noiseImage(double sigma, int seed) {
  sim::Scene scene;
  scene.background = 120.0;
  scene.noise = sigma;
  scene.seed = seed;
  return sim::takeImage(camera(false), scene);
}

/// Bright to the right of a line through the middle of the image; `normal` is the line's.
cv::Mat stepImage(const Eigen::Vector2d& normal) {
  cv::Mat image(480, 640, CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double off = normal.dot(Eigen::Vector2d(x - 320.0, y - 240.0));
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(60.0 + 100.0 * std::clamp(off + 0.5, 0.0, 1.0));
    }
  }
  return image;
}

/// Distance in field pixels from the place that is seen at an ideal image point, rounded to a
/// pixel.
double distanceAt(const Field& field, const Eigen::Vector2d& ideal, int bin) {
  const int x = static_cast<int>(std::lround(field.focal * ideal.x() + field.cx));
  const int y = static_cast<int>(std::lround(field.focal * ideal.y() + field.cy));
  return field.at(x, y)[bin] / static_cast<double>(kUnitsPerFieldPixel);
}

TEST(Edges, AFlatImageHasNone) {
  const EdgeMap map = edgesOf(cv::Mat(480, 640, CV_8U, cv::Scalar(90)), camera(true));
  EXPECT_EQ(map.edgels, 0u);
  ASSERT_FALSE(map.fieldOf(0).distance.empty());
  EXPECT_EQ(*std::min_element(map.fieldOf(0).distance.begin(), map.fieldOf(0).distance.end()),
            kFarDistance);
}

TEST(Edges, AStepIsFoundInPlaceAndDirection) {
  for (const double angle_deg : {0.0, 22.5, 45.0, 90.0, 123.75, 157.5}) {
    const Eigen::Vector2d n(std::cos(angle_deg * kDegrees), std::sin(angle_deg * kDegrees));
    const EdgeMap map = edgesOf(stepImage(n), camera(false));
    const int bin = directionBin(n.x(), n.y()), across = (bin + kDirections / 2) % kDirections;
    for (const double along : {-120.0, -31.0, 0.0, 77.0}) {  // image pixels
      const Eigen::Vector2d on = along * Eigen::Vector2d(-n.y(), n.x()) / 900.0;
      EXPECT_LE(distanceAt(map.fieldOf(0), on, bin), 1.0) << angle_deg << ", " << along;
      EXPECT_GT(distanceAt(map.fieldOf(0), on, across), 20.0) << angle_deg << ", " << along;
      // The next direction may serve at the price of one field pixel.
      EXPECT_LE(distanceAt(map.fieldOf(0), on, (bin + 1) % kDirections), 2.0) << angle_deg;
    }
  }
}

TEST(Edges, DistancesGrowAcrossAStep) {
  for (const double angle_deg : {0.0, 45.0, 90.0}) {
    const Eigen::Vector2d n(std::cos(angle_deg * kDegrees), std::sin(angle_deg * kDegrees));
    const EdgeMap map = edgesOf(stepImage(n), camera(false));
    const int bin = directionBin(n.x(), n.y());
    for (int off = -30; off <= 30; off += 3) {  // field pixels
      const Eigen::Vector2d at = off * map.fieldOf(0).image_px / 900.0 * n;
      // The 3-4 chamfer is right to 6 %; rounding to field pixels at both ends adds one.
      EXPECT_NEAR(distanceAt(map.fieldOf(0), at, bin), std::abs(off), 1.0 + 0.06 * std::abs(off))
          << angle_deg << ", " << off;
    }
  }
}

TEST(Edges, TheLensIsUndone) {
  const sim::PinholeCamera from = camera(true);
  // Sides that the lens bends by up to 9 pixels, seen from 0.5 m.
  const sim::Plate plate{rectangle(-150, -110, 150, 110), {}, {}, 0.0};
  const EdgeMap map = edgesOf(sim::takeImage(from, sceneOf(plate, {0, 0, 500})), from);
  for (double s = -0.9; s <= 0.9; s += 0.1) {
    for (const double side : {-1.0, 1.0}) {
      // Half a field pixel each from the edgel's and the asked pixel's rounding, in either axis.
      EXPECT_LE(distanceAt(map.fieldOf(0), {side * 0.3, s * 0.22}, 0), 4.0 / 3.0) << s;
      EXPECT_LE(distanceAt(map.fieldOf(0), {s * 0.3, side * 0.22}, kDirections / 2), 4.0 / 3.0)
          << s;
    }
  }
}

TEST(Edges, NoiseHasFew) {
  for (const double sigma : {2.0, 5.0}) {
    for (const int seed : {1, 2, 3}) {
      const cv::Mat image = noiseImage(sigma, seed);
      // A pixel's gradient passes 4 sigma with exp(-8) = 3e-4; then it must be a ridge and go on.
      EXPECT_LT(edgesOf(image, camera(false)).edgels, 1e-4 * image.total()) << sigma;
    }
  }
}

TEST(Edges, NoiseIsMeasured) {
  for (const double sigma : {1.0, 2.0, 5.0, 8.0}) {
    const EdgeMap map = edgesOf(noiseImage(sigma, 4), camera(false));
    EXPECT_NEAR(map.noise[120], sigma, 0.15 * sigma);
  }
}

TEST(Edges, NoiseIsMeasuredByGreyLevel) {
  cv::Mat image = noiseImage(2.0, 5);
  cv::Mat bright = noiseImage(6.0, 6);
  bright += 80;
  bright(cv::Rect(320, 0, 320, 480)).copyTo(image(cv::Rect(320, 0, 320, 480)));
  const EdgeMap map = edgesOf(image, camera(false));
  EXPECT_NEAR(map.noise[120], 2.0, 0.4);
  EXPECT_NEAR(map.noise[200], 6.0, 1.2);
}

TEST(Edges, TwelveBitsInSixteenEqualEight) {
  sim::Scene scene = sceneOf(bracketPlate(), {0, 0, 400, 30});
  scene.plates[0].grey = 180.0;  // reaches the highest of the 12 bits
  const cv::Mat eight = sim::takeImage(camera(true), scene);
  cv::Mat twelve;
  eight.convertTo(twelve, CV_16U, 16.0);
  for (int y = 0; y < twelve.rows; ++y) {  // what the lowest bits hold must not matter
    for (int x = 0; x < twelve.cols; ++x) {
      auto& value = twelve.at<std::uint16_t>(y, x);
      value = static_cast<std::uint16_t>(value + (7 * x + 3 * y) % 16);
    }
  }
  const EdgeMap a = edgesOf(eight, camera(true)), b = edgesOf(twelve, camera(true));
  EXPECT_GT(a.edgels, 300u);
  EXPECT_EQ(a.edgels, b.edgels);
  EXPECT_TRUE(a.fieldOf(0).distance == b.fieldOf(0).distance);
  EXPECT_EQ(a.noise, b.noise);
  EXPECT_EQ(cv::norm(a.image, b.image, cv::NORM_INF), 0.0);
}

TEST(Edges, ThreadsDoNotMatter) {
  const sim::Scene scene = sceneOf(bracketPlate(), {0, 0, 400, 30});
  const cv::Mat image = sim::takeImage(camera(true), scene);
  const EdgeMap one = edgesOf(image, camera(true), 1);
  for (const int threads : {2, 3}) {
    const EdgeMap more = edgesOf(image, camera(true), threads);
    EXPECT_EQ(more.edgels, one.edgels);
    EXPECT_TRUE(more.fieldOf(0).distance == one.fieldOf(0).distance);
  }
}

TEST(Edges, LargeImagesAreShrunkByWholeNumbers) {
  sim::PinholeCamera large = camera(true);
  large.width *= 3;
  large.height *= 3;
  for (double* v : {&large.fx, &large.fy, &large.cx, &large.cy}) *v *= 3.0;
  const sim::Plate plate{rectangle(-150, -110, 150, 110), {}, {}, 0.0};
  const EdgeMap map = edgesOf(sim::takeImage(large, sceneOf(plate, {0, 0, 500})), large);
  EXPECT_EQ(map.fieldOf(0).image_px, 2.0 * std::lround(std::sqrt(2.7648 / 1.3)));
  for (double s = -0.9; s <= 0.9; s += 0.1) {
    EXPECT_LE(distanceAt(map.fieldOf(0), {0.3, s * 0.22}, 0), 4.0 / 3.0) << s;
  }
}

// A part's radius gets about as many pixels as the parameter says, from above; parts of one scale
// share a field.
TEST(Edges, LargePartsAreSoughtInASmallerImage) {
  const cv::Mat image = sim::takeImage(camera(true), sceneOf(bracketPlate(), {0, 0, 400, 30}));
  EdgesParams params;
  params.radius_px = 100.0;
  const EdgeMap map =
      findEdges(image, makeCamera(camera(true)), {40.0, 199.0, 350.0, 60.0}, params, 1);
  ASSERT_EQ(map.fields.size(), 2u);
  EXPECT_EQ(map.field_of, (std::vector<std::size_t>{0, 0, 1, 0}));
  EXPECT_EQ(map.fieldOf(0).image_px, 2.0);
  EXPECT_EQ(map.fieldOf(2).image_px, 6.0);
  EXPECT_NEAR(map.fieldOf(2).width, map.fieldOf(0).width / 3.0, 3.0);
}

}  // namespace
}  // namespace planar_bin_picking
