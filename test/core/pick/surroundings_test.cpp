// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/surroundings.h"

#include "planar_bin_picking/image/grey.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace planar_bin_picking {
namespace {

/// 0.8 m below the camera, front up.
Eigen::Isometry3d lyingAt(double x) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, 0.0, 0.8);
  T.linear() = Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return T;
}

/// A camera over a part, and the picture of it in so many bits.
class SurroundingsTest : public testing::Test {
 protected:
  static Camera camera() {
    Camera::Model model;
    model.width = 640, model.height = 480, model.fx = model.fy = 800.0, model.cx = 320.0,
    model.cy = 240.0;
    return Camera(model);
  }

  static cv::Mat deepened(const cv::Mat& grey, int bits) {
    cv::Mat deep = grey;
    if (bits > 8) grey.convertTo(deep, CV_16U, 1 << (bits - 8));
    return deep;
  }

  Surroundings cut(const cv::Mat& image, double x = 0.0) const {
    return cutSurroundings({image, bitsInUse(image), camera_}, lyingAt(x), Eigen::Vector3d::Zero(),
                           0.08);
  }

  SurroundingsTest() : grey_(480, 640, CV_8U, cv::Scalar(90)) {
    grey_(cv::Rect(300, 220, 40, 40)).setTo(150);
  }

  const Camera camera_ = camera();
  cv::Mat grey_;
};

TEST_F(SurroundingsTest, ChangesWithTheSceneAndNotWithTheLamp) {
  const Surroundings before = cut(grey_);
  ASSERT_FALSE(before.patch.empty());
  EXPECT_NEAR(cv::mean(before.patch)[0], 0.0, 1e-3);
  EXPECT_LT(difference(before, cut(grey_ + 20)), 0.5);
  grey_(cv::Rect(345, 180, 30, 120)).setTo(150);
  EXPECT_GT(difference(before, cut(grey_)), 12.0);
}

// 80 mm at 0.8 m and 800 px: the square reaches 80 px from the middle.
TEST_F(SurroundingsTest, TakesTheSquareAboutThePart) {
  const Surroundings before = cut(grey_);
  cv::Mat beside = grey_.clone();
  beside(cv::Rect(402, 0, 238, 480)).setTo(255);
  beside(cv::Rect(0, 0, 238, 480)).setTo(255);
  beside(cv::Rect(0, 0, 640, 158)).setTo(255);
  beside(cv::Rect(0, 322, 640, 158)).setTo(255);
  EXPECT_EQ(difference(before, cut(beside)), 0.0);
  beside = grey_.clone();
  beside(cv::Rect(395, 0, 5, 480)).setTo(255);
  EXPECT_GT(difference(before, cut(beside)), 1.0);
  EXPECT_TRUE(cut(grey_, 0.3).patch.empty());  // not wholly in the image
  EXPECT_TRUE(cut(grey_, -0.241).patch.empty());
  EXPECT_FALSE(cut(grey_, -0.238).patch.empty());
}

// Whatever the camera's depth: a change is as large in its levels as in those of 8 bits.
TEST_F(SurroundingsTest, CountsInLevelsOfEightBits) {
  cv::Mat changed = grey_.clone(), spotted = grey_.clone();
  changed(cv::Rect(345, 180, 30, 120)).setTo(150);
  spotted(cv::Rect(0, 0, 20, 20)).setTo(255);  // beside the part: all bits are in use
  const double expected = difference(cut(grey_), cut(changed));
  EXPECT_GT(expected, 12.0);
  for (const int bits : {8, 10, 12, 16}) {
    SCOPED_TRACE(bits);
    // The darker one does not show its highest bit, and is of the same camera all the same.
    const Surroundings before = cut(deepened(spotted, bits)), after = cut(deepened(changed, bits));
    EXPECT_NEAR(difference(before, after), expected, 0.2);
    EXPECT_NEAR(difference(after, before), expected, 0.2);
    EXPECT_LT(difference(before, cut(deepened(grey_ + 4, bits))), 0.5);
  }
}

TEST_F(SurroundingsTest, NothingToCompareTellsOfNoChange) {
  EXPECT_EQ(difference(cut(grey_), {}), 0.0);
  EXPECT_EQ(difference({}, cut(grey_)), 0.0);
}

}  // namespace
}  // namespace planar_bin_picking
