// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/texture.h"

#include "image/edges.h"
#include "support/plates.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <cmath>
#include <cstdint>

namespace planar_bin_picking {
namespace {

constexpr int kStep = 320;

/// Left of the middle column smooth, right of it brighter and mottled.
cv::Mat mottledImage() {
  constexpr double kSpots = 1.5, kContrast = 8.0;  // pixels; standard deviation, grey levels
  cv::Mat mottle(480, 640, CV_32F), image;
  cv::RNG random(1);
  random.fill(mottle, cv::RNG::NORMAL, 0.0, 1.0);
  cv::GaussianBlur(mottle, mottle, {}, kSpots);
  mottle *= kContrast * 2.0 * std::sqrt(M_PI) * kSpots;  // what the blur took
  mottle += 160.0;
  mottle(cv::Rect(0, 0, kStep, 480)) = 60.0;
  mottle.convertTo(image, CV_8U);
  return image;
}

TEST(Texture, IsWhereItIsAndLeavesContoursOut) {
  const Texture texture(mottledImage(), 1);
  EXPECT_EQ(texture.at(100, 200), 0.0f);
  EXPECT_EQ(texture.at(kStep - 20, 200), 0.0f);  // two blocks beside the step
  // A mottle's gradient has kContrast / (sqrt(2) kSpots) per component; the mean of both together
  // is 1.25 times that.
  for (const int x : {420, 500, 639})
    EXPECT_NEAR(texture.at(x, 479 - x / 4) / 32.0f, 1.25 * 8.0 / (1.414 * 1.5), 1.5) << x;
}

TEST(Texture, ThreadsDoNotMatter) {
  const cv::Mat image = mottledImage();
  const Texture one(image, 1), three(image, 3);
  for (int y = 0; y < image.rows; y += 7)
    for (int x = 0; x < image.cols; x += 7) EXPECT_EQ(one.at(x, y), three.at(x, y));
}

/// Levels side by side are found together, where there are as many.
TEST(Texture, IsTheSameInAPieceOfTheImage) {
  const cv::Mat image = mottledImage();
  const Texture whole(image, 1);
  for (int col = 2; col < 76; ++col) {
    // Two blocks to the right that a level is taken from, and the border's gradient behind.
    const Texture piece(image(cv::Rect(0, 0, 8 * (col + 4), image.rows)), 1);
    for (int y = 0; y < image.rows; y += 8) EXPECT_EQ(piece.at(8 * col, y), whole.at(8 * col, y));
  }
}

TEST(Texture, SmallImagesHaveOneToo) {
  const Texture texture(cv::Mat(5, 3, CV_8U, cv::Scalar(80)), 1);
  EXPECT_EQ(texture.at(2, 4), 0.0f);
}

TEST(Texture, ItsEdgelsCountAsFarther) {
  sim::PinholeCamera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 900.0, camera.cx = 320.0, camera.cy = 240.0;
  camera.lens = {};
  EdgesParams params;
  const auto shareAtZero = [&](const EdgeMap& map, int x0, int x1) {
    int zero = 0, all = 0;
    for (int y = 20; y < map.fieldOf(0).height - 20; ++y) {
      for (int x = x0; x < x1; ++x, ++all) {
        const auto* d = map.fieldOf(0).at(x, y);
        zero += *std::min_element(d, d + kDirections) == 0;
      }
    }
    return static_cast<double>(zero) / all;
  };
  const EdgeMap map = findEdges(mottledImage(), makeCamera(camera), params, 1);
  params.texture_factor = 0.0;
  const EdgeMap without = findEdges(mottledImage(), makeCamera(camera), params, 1);
  EXPECT_EQ(map.edgels, without.edgels);  // none is lost
  const int step = static_cast<int>(map.fieldOf(0).cx), right = map.fieldOf(0).width - 10;
  EXPECT_GT(shareAtZero(without, step + 20, right), 0.3);
  EXPECT_LT(shareAtZero(map, step + 20, right), 0.5 * shareAtZero(without, step + 20, right));
  // The step itself stands as it did: one column of the field.
  EXPECT_GT(shareAtZero(map, step - 3, step + 4), 0.8 / 7.0);
}

}  // namespace
}  // namespace planar_bin_picking
