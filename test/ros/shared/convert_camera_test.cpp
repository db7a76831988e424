// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/convert_camera.h"
#include "shared/refusal.h"
#include "support/matchers.h"

#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>
#include <boost/make_shared.hpp>

namespace planar_bin_picking_ros {
namespace {

namespace enc = sensor_msgs::image_encodings;
using planar_bin_picking::Camera;
using planar_bin_picking::refuses;

constexpr int kWidth = 8, kHeight = 6;

/// An image in which every byte of every channel is `value`.
sensor_msgs::ImagePtr makeImage(const std::string& encoding, const std::uint8_t value = 100) {
  const auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.frame_id = "camera";
  image->width = kWidth;
  image->height = kHeight;
  image->encoding = encoding;
  const int channels = encoding == "yuv422" ? 2 : enc::numChannels(encoding);
  image->step = kWidth * channels * (enc::bitDepth(encoding) / 8);
  image->data.assign(image->step * kHeight, value);
  return image;
}

sensor_msgs::CameraInfo makeInfo() {
  sensor_msgs::CameraInfo info;
  info.width = kWidth;
  info.height = kHeight;
  info.distortion_model = "plumb_bob";
  info.D = {0.0, 0.0, 0.0, 0.0, 0.0};
  info.K = {10.0, 0.0, 4.0, 0.0, 11.0, 3.0, 0.0, 0.0, 1.0};
  return info;
}

class EveryEncoding : public testing::TestWithParam<std::string> {};

TEST_P(EveryEncoding, BecomesGrey) {
  const auto image = makeImage(GetParam());
  const cv::Mat grey = toGrey(image);
  ASSERT_EQ(grey.size(), cv::Size(kWidth, kHeight));
  const bool deep = enc::bitDepth(GetParam()) == 16;
  ASSERT_EQ(grey.type(), deep ? CV_16UC1 : CV_8UC1);
  // All channels alike, hence grey; 1 for rounding of the weights.
  if (deep) {
    EXPECT_NEAR(grey.at<std::uint16_t>(3, 4), 100 * 257, 257);
  } else {
    EXPECT_NEAR(grey.at<std::uint8_t>(3, 4), 100, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Convert, EveryEncoding,
                         testing::Values("mono8", "mono16", "8UC1", "16UC1", "8UC3", "8UC4", "bgr8",
                                         "rgb8", "bgra8", "rgba8", "bgr16", "rgb16", "bgra16",
                                         "rgba16", "bayer_rggb8", "bayer_bggr8", "bayer_gbrg8",
                                         "bayer_grbg8", "bayer_rggb16", "bayer_bggr16",
                                         "bayer_gbrg16", "bayer_grbg16", "yuv422"));

TEST(ToGrey, MonoIsNotCopied) {
  const auto image = makeImage("mono8");
  EXPECT_EQ(toGrey(image).data, image->data.data());
}

TEST(ToGrey, ColorIsWeighted) {
  const auto image = makeImage("rgb8", 0);
  for (std::size_t i = 0; i < image->data.size(); i += 3) image->data[i] = 200;  // red
  EXPECT_NEAR(toGrey(image).at<std::uint8_t>(0, 0), 0.299 * 200, 1);
}

TEST(ToGrey, PaddedRows) {
  const auto image = makeImage("mono8");
  image->step = kWidth + 5;
  image->data.assign(image->step * kHeight, 7);
  EXPECT_EQ(toGrey(image).at<std::uint8_t>(kHeight - 1, kWidth - 1), 7);
}

// cv_bridge makes two channels of 8 bits of it.
TEST(ToGrey, BigEndian) {
  for (const char* encoding : {"mono16", "16UC1", "bayer_rggb16", "rgb16"}) {
    const auto image = makeImage(encoding, 0);
    image->is_bigendian = true;
    for (std::size_t i = 0; i < image->data.size(); i += 2) {
      image->data[i] = 3;  // the high byte comes first
      image->data[i + 1] = 5;
    }
    const cv::Mat grey = toGrey(image);
    ASSERT_EQ(grey.type(), CV_16UC1) << encoding;
    ASSERT_EQ(grey.size(), cv::Size(kWidth, kHeight));
    EXPECT_NEAR(grey.at<std::uint16_t>(kHeight - 1, kWidth - 1), 3 * 256 + 5, 1) << encoding;
  }
}

TEST(ToGrey, Refuses) {
  const auto refused = [](const std::string& word, const auto& spoil) {
    const auto image = makeImage("mono8");
    spoil(*image);
    return refuses([&] { toGrey(image); }, {word});
  };
  using Image = sensor_msgs::Image;
  EXPECT_TRUE(refused("32FC1", [](Image& i) { i.encoding = "32FC1"; }));
  EXPECT_TRUE(refused("16SC1", [](Image& i) { i.encoding = "16SC1"; }));
  EXPECT_TRUE(refused("jpeg", [](Image& i) { i.encoding = "jpeg"; }));
  EXPECT_TRUE(refused("frame_id", [](Image& i) { i.header.frame_id = ""; }));
  EXPECT_TRUE(refused("empty", [](Image& i) { i.width = 0; }));
  EXPECT_TRUE(refused("too few", [](Image& i) { i.data.resize(10); }));
  EXPECT_TRUE(refused("step", [](Image& i) { i.step = 2; }));
}

TEST(ToCamera, TakesOverTheModel) {
  const Camera camera = toCamera(makeInfo(), *makeImage("mono8"));
  EXPECT_EQ(camera.model().width, kWidth);
  EXPECT_EQ(camera.model().fx, 10.0);
  EXPECT_EQ(camera.model().fy, 11.0);
  EXPECT_EQ(camera.model().cx, 4.0);
  EXPECT_EQ(camera.model().cy, 3.0);
  EXPECT_EQ(camera.model().distortion_model, "plumb_bob");
}

TEST(ToCamera, RegionOfInterestMovesTheCentre) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.width = 20;
  info.height = 16;
  info.roi.x_offset = 2;
  info.roi.y_offset = 1;
  info.roi.width = kWidth;
  info.roi.height = kHeight;
  const Camera camera = toCamera(info, *makeImage("mono8"));
  EXPECT_EQ(camera.model().cx, 2.0);
  EXPECT_EQ(camera.model().cy, 2.0);
  EXPECT_EQ(camera.model().fx, 10.0);
}

// A point that fell on the middle of sensor pixels 2k and 2k + 1 must fall on the centre of binned
// pixel k.
TEST(ToCamera, BinningKeepsPixelCentres) {
  sensor_msgs::CameraInfo info = makeInfo();
  info.width = 2 * kWidth;
  info.height = 2 * kHeight;
  info.binning_x = info.binning_y = 2;
  const Camera camera = toCamera(info, *makeImage("mono8"));
  const Eigen::Vector3d point((2.5 - 4.0) / 10.0, (4.5 - 3.0) / 11.0, 1.0);  // at sensor 2.5, 4.5
  EXPECT_LT((camera.project(point) - Eigen::Vector2d(1.0, 2.0)).norm(), 1e-9);
}

TEST(ToCamera, Refuses) {
  const auto refused = [](const std::string& word, const auto& spoil) {
    sensor_msgs::CameraInfo info = makeInfo();
    spoil(info);
    return refuses([&] { toCamera(info, *makeImage("mono8")); }, {"camera_info", word});
  };
  using Info = sensor_msgs::CameraInfo;
  EXPECT_TRUE(refused("not calibrated", [](Info& i) { i.K.fill(0.0); }));
  EXPECT_TRUE(refused("pixels", [](Info& i) { i.width = 9; }));
  EXPECT_TRUE(refused("pixels", [](Info& i) { i.binning_x = 2; }));
  EXPECT_TRUE(refused("equidistant", [](Info& i) { i.distortion_model = "equidistant"; }));
  EXPECT_TRUE(refused("skew", [](Info& i) { i.K[1] = 500.0; }));
  EXPECT_TRUE(refused("pinhole", [](Info& i) { i.K[8] = 2.0; }));
  EXPECT_TRUE(refused("", [](Info& i) { i.K[0] = std::nan(""); }));
  EXPECT_TRUE(refused("", [](Info& i) { i.D[0] = std::nan(""); }));
}

}  // namespace
}  // namespace planar_bin_picking_ros
