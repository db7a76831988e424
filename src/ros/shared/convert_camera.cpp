// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/convert_camera.h"

#include "shared/refusal.h"

#include <cv_bridge/cv_bridge.h>
#include <planar_bin_picking/LocatePart.h>
#include <sensor_msgs/image_encodings.h>
#include <boost/make_shared.hpp>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>

namespace planar_bin_picking_ros {

namespace enc = sensor_msgs::image_encodings;
using planar_bin_picking::Camera;
using planar_bin_picking::LocatePart;

namespace {

[[noreturn]] void refuseImage(const std::string& message) {
  throw Refusal(LocatePart::Response::BAD_IMAGE, "image: " + message);
}

[[noreturn]] void refuseInfo(const std::string& message) {
  throw Refusal(LocatePart::Response::BAD_CAMERA_INFO, "camera_info: " + message);
}

std::string size(const std::size_t width, const std::size_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// Bits of one channel; cv_bridge would turn 32-bit or float data into grey without a word.
int depth(const std::string& encoding) {
  try {
    return enc::bitDepth(encoding);
  } catch (const std::runtime_error&) {
    return 0;
  }
}

bool isPlain(const std::string& encoding) {
  return encoding == enc::MONO8 || encoding == enc::MONO16 || encoding == enc::TYPE_8UC1 ||
         encoding == enc::TYPE_16UC1;
}

void checkImage(const sensor_msgs::Image& image) {
  if (image.header.frame_id.empty()) {
    refuseImage("header.frame_id is empty; set the camera's optical frame in its driver");
  }
  if (image.width == 0 || image.height == 0) refuseImage("is empty; check the camera");
  const int bits = depth(image.encoding);
  const bool is_signed = image.encoding.find('S') != std::string::npos;
  if ((bits != 8 && bits != 16) || is_signed) {
    refuseImage("encoding '" + image.encoding +
                "' is not 8 or 16 bit mono, colour, Bayer or YUV; set another in the driver");
  }
  if (image.data.size() < std::size_t{image.step} * image.height) {
    refuseImage(std::to_string(image.data.size()) + " bytes of data are too few for " +
                size(image.width, image.height) + " pixels with step " +
                std::to_string(image.step) + "; check the driver");
  }
}

/// cv_bridge mixes bytes up when the other order comes in.
bool isSwapped(const sensor_msgs::Image& image) {
  const std::uint16_t one = 1;
  const bool host_is_big = *reinterpret_cast<const std::uint8_t*>(&one) == 0;
  return depth(image.encoding) == 16 && (image.is_bigendian != 0) != host_is_big;
}

sensor_msgs::ImageConstPtr inHostOrder(const sensor_msgs::Image& image) {
  const auto swapped = boost::make_shared<sensor_msgs::Image>(image);
  swapped->is_bigendian = image.is_bigendian == 0;
  for (std::size_t i = 0; i + 1 < swapped->data.size(); i += 2)
    std::swap(swapped->data[i], swapped->data[i + 1]);
  return swapped;
}

/// One axis of the pinhole, from the full sensor to the image that was read out.
struct Axis {
  double focal, center;
};

Axis readOut(const Axis& sensor, const std::uint32_t offset, const std::uint32_t binning) {
  // Pixel 0 of a binned image is the mean of `binning` pixels, whose centre lies between them.
  return {sensor.focal / binning, (sensor.center - offset - 0.5 * (binning - 1.0)) / binning};
}

}  // namespace

cv::Mat toGrey(const sensor_msgs::ImageConstPtr& image) {
  checkImage(*image);
  if (isSwapped(*image)) return toGrey(inHostOrder(*image)).clone();
  try {
    if (isPlain(image->encoding)) return cv_bridge::toCvShare(image)->image;
    if (image->encoding == enc::TYPE_8UC3 || image->encoding == enc::TYPE_8UC4) {
      cv::Mat grey;
      const cv::Mat color = cv_bridge::toCvShare(image)->image;
      cv::cvtColor(color, grey, color.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
      return grey;
    }
    const bool deep = depth(image->encoding) == 16;
    return cv_bridge::toCvShare(image, deep ? enc::MONO16 : enc::MONO8)->image;
  } catch (const cv_bridge::Exception& error) {
    refuseImage(std::string(error.what()) + "; check the driver's encoding and step");
  }
}

Camera toCamera(const sensor_msgs::CameraInfo& info, const sensor_msgs::Image& image) {
  if (info.K[0] == 0.0) {
    refuseInfo(
        "K is zero, the camera is not calibrated; calibrate it and let its driver load the "
        "result (camera_info_url)");
  }
  const std::uint32_t bin_x = std::max(1u, info.binning_x), bin_y = std::max(1u, info.binning_y);
  const bool has_roi = info.roi.width != 0 && info.roi.height != 0;
  const std::uint32_t width = (has_roi ? info.roi.width : info.width) / bin_x;
  const std::uint32_t height = (has_roi ? info.roi.height : info.height) / bin_y;
  if (width != image.width || height != image.height) {
    refuseInfo("is for " + size(width, height) + " pixels, the image has " +
               size(image.width, image.height) +
               "; calibrate at this resolution, or let the driver fill in roi and binning");
  }
  try {
    std::array<double, 9> K;
    std::copy(info.K.begin(), info.K.end(), K.begin());
    Camera::Model model =
        planar_bin_picking::pinholeModel(static_cast<int>(width), static_cast<int>(height), K);
    const Axis x = readOut({model.fx, model.cx}, has_roi ? info.roi.x_offset : 0, bin_x);
    const Axis y = readOut({model.fy, model.cy}, has_roi ? info.roi.y_offset : 0, bin_y);
    model.fx = x.focal;
    model.fy = y.focal;
    model.cx = x.center;
    model.cy = y.center;
    model.distortion_model = info.distortion_model;
    model.distortion = info.D;
    return Camera(model);
  } catch (const std::invalid_argument& error) {
    refuseInfo(std::string(error.what()) + "; calibrate the camera anew");
  }
}

}  // namespace planar_bin_picking_ros
