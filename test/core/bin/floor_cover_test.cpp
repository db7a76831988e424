// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/bin/floor_cover.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <vector>

namespace planar_bin_picking {
namespace {

constexpr double kMark = 0.02;  // metres

Camera testCamera() {
  Camera::Model model;
  model.width = 640, model.height = 512;
  model.fx = model.fy = 800.0, model.cx = 320.0, model.cy = 256.0;
  return Camera(model);
}

/// A bin of 0.4 x 0.3 m below a camera that looks straight down from 0.75 m.
BinBox testBin() {
  BinBox bin;
  bin.T_camera_bin = Eigen::Translation3d(0.0, 0.0, 0.75) *
                     Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX());
  bin.min = {-0.2, -0.15, 0.0};
  bin.max = {0.2, 0.15, 0.1};
  return bin;
}

std::vector<cv::Point> rectangle(double x0, double y0, double x1, double y1) {
  const Camera camera = testCamera();
  std::vector<cv::Point> points;
  for (const auto& [x, y] : {std::pair{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}) {
    const Eigen::Vector2d p = camera.project(testBin().T_camera_bin * Eigen::Vector3d(x, y, 0.0));
    points.emplace_back(static_cast<int>(p.x() + 0.5), static_cast<int>(p.y() + 0.5));
  }
  return points;
}

/// A grainy grey floor between bright walls, and dark plates on it.
cv::Mat picture(const std::vector<std::vector<cv::Point>>& plates, double brightness = 110.0) {
  cv::Mat grey(512, 640, CV_8U, cv::Scalar(200));
  cv::fillConvexPoly(grey, rectangle(-0.2, -0.15, 0.2, 0.15), cv::Scalar(brightness));
  for (const auto& plate : plates) cv::fillConvexPoly(grey, plate, cv::Scalar(0.5 * brightness));
  cv::GaussianBlur(grey, grey, {3, 3}, 0.7);
  cv::Mat noise(grey.size(), CV_16S), sum;
  cv::RNG(3).fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
  grey.convertTo(sum, CV_16S);
  sum += noise;
  sum.convertTo(grey, CV_8U);
  return grey;
}

FloorCover look(const cv::Mat& image) { return findFloorCover(image, testCamera(), testBin()); }

TEST(FloorCover, ABareFloorIsEmpty) {
  const FloorCover cover = look(picture({}));
  EXPECT_TRUE(cover.isEmpty(kMark)) << cover.doubt << " " << cover.longest;
  EXPECT_LT(cover.covered, 0.002);
  EXPECT_FALSE(cover.isEmpty(0.0)) << "a mark of 0 switches it off";
}

TEST(FloorCover, OnePlateIsSomethingAndCoversItsArea) {
  const FloorCover cover = look(picture({rectangle(-0.05, -0.03, 0.05, 0.03)}));
  EXPECT_FALSE(cover.isEmpty(kMark));
  // 0.1 x 0.06 of 0.384 x 0.284 m; edges are about two pixels of 0.94 mm wide on each side.
  EXPECT_NEAR(cover.covered, 0.055, 0.008);
  EXPECT_NEAR(cover.longest, 0.117, 0.02);  // the larger pixels have 4 mm
}

TEST(FloorCover, SmallMarksAreTheFloorsOwn) {
  const FloorCover cover = look(picture({rectangle(-0.002, -0.002, 0.002, 0.002)}));
  EXPECT_GT(cover.longest, 0.002);
  EXPECT_TRUE(cover.isEmpty(kMark));
  EXPECT_FALSE(cover.isEmpty(0.003));
}

TEST(FloorCover, WhatIsOutOfFocusIsSeenAllTheSame) {
  cv::Mat image = picture({rectangle(-0.05, -0.03, 0.05, 0.03)});
  cv::GaussianBlur(image, image, {}, 4.0);
  EXPECT_FALSE(look(image).isEmpty(kMark));
}

TEST(FloorCover, SixteenBitsSayTheSame) {
  cv::Mat image;
  picture({rectangle(-0.05, -0.03, 0.05, 0.03)}).convertTo(image, CV_16U, 16.0);
  EXPECT_NEAR(look(image).covered, 0.055, 0.008);
}

TEST(FloorCover, LocatedPartsCoverTheFloorBehindThem) {
  // A plate 75 mm over the floor hides 10/9 of its size each way. Nothing of it is in the picture.
  std::vector<Eigen::Vector3d> outline;
  for (const auto& [x, y] : {std::pair{-0.09, -0.09}, {0.09, -0.09}, {0.09, 0.09}, {-0.09, 0.09}})
    outline.push_back(testBin().T_camera_bin * Eigen::Vector3d(x, y, 0.075));
  const FloorCover cover = findFloorCover(picture({}), testCamera(), testBin(), {outline});
  EXPECT_NEAR(cover.covered, 0.2 * 0.2 / (0.384 * 0.284), 0.01);
}

// What cannot be seen may be anything: in doubt there is something.
TEST(FloorCover, BadPicturesAreInDoubt) {
  const cv::Mat covered(512, 640, CV_8U, cv::Scalar(0));
  EXPECT_NE(look(covered).doubt.find("too dark"), std::string::npos);
  EXPECT_FALSE(look(covered).isEmpty(kMark));
  EXPECT_NE(look(cv::Mat(512, 640, CV_8U, cv::Scalar(255))).doubt.find("overexposed"),
            std::string::npos);
  EXPECT_NE(look(cv::Mat(512, 640, CV_8U, cv::Scalar(100))).doubt.find("uniform"),
            std::string::npos);
  cv::Mat shadow = picture({});
  cv::fillConvexPoly(shadow, rectangle(0.12, -0.15, 0.2, 0.15), cv::Scalar(2));
  EXPECT_NE(look(shadow).doubt.find("too dark"), std::string::npos);
}

TEST(FloorCover, APartOfTheFloorOutOfViewIsInDoubt) {
  BinBox bin = testBin();
  bin.T_camera_bin = Eigen::Translation3d(0.2, 0.0, 0.0) * bin.T_camera_bin;
  const FloorCover cover = findFloorCover(picture({}), testCamera(), bin);
  EXPECT_NE(cover.doubt.find("in view"), std::string::npos);
  EXPECT_TRUE(cover.known());
  bin.T_camera_bin = Eigen::Translation3d(2.0, 0.0, 0.0) * bin.T_camera_bin;
  const FloorCover none = findFloorCover(picture({}), testCamera(), bin);
  EXPECT_FALSE(none.known());
  EXPECT_FALSE(none.isEmpty(kMark));
}

// From aside, the near wall hides a strip of the floor.
TEST(FloorCover, NumbersFarTooLargeAreInDoubt) {
  for (const double half : {50.0, 1e5, 1e12}) {
    BinBox bin = testBin();
    bin.min.head<2>().setConstant(-half);
    bin.max.head<2>().setConstant(half);
    const FloorCover cover = findFloorCover(picture({}), testCamera(), bin);
    EXPECT_FALSE(cover.isEmpty(kMark)) << half;
    EXPECT_NE(cover.doubt, "");
  }
  // A part as high as the eye, whose shadow on the floor has no end.
  const std::vector<Eigen::Vector3d> high = {{0.1, 0.0, 1e-9}, {0.2, 0.0, 1e-9}, {0.2, 0.1, 1e-9}};
  EXPECT_NO_THROW(findFloorCover(picture({}), testCamera(), testBin(), {high}));
}

TEST(FloorCover, WhatTheWallsHideIsNotInView) {
  BinBox bin = testBin();
  bin.max.z() = 0.5;
  bin.T_camera_bin = bin.T_camera_bin * Eigen::Translation3d(-0.15, 0.0, 0.0);
  EXPECT_NE(findFloorCover(picture({}), testCamera(), bin).doubt.find("in view"),
            std::string::npos);
}

}  // namespace
}  // namespace planar_bin_picking
