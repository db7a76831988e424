// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/view.h"

#include "image/edges.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace planar_bin_picking {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("view: " + what); }

void check(const cv::Mat& image, const Camera& camera, const Eigen::Isometry3d& T_first_this) {
  if (image.empty()) refuse("the image is empty");
  if (image.channels() != 1 || (image.depth() != CV_8U && image.depth() != CV_16U)) {
    refuse("the image has " + std::to_string(image.channels()) + " channels of depth " +
           std::to_string(image.depth()) + "; give one channel of 8 or 16 bit");
  }
  constexpr int kSlack = 2;  // as Locator::locate: some drivers pad or crop
  if (std::abs(image.cols - camera.model().width) > kSlack ||
      std::abs(image.rows - camera.model().height) > kSlack) {
    refuse("the image is " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
           ", the camera info " + std::to_string(camera.model().width) + " x " +
           std::to_string(camera.model().height) + "; they must be of one size");
  }
  if (image.cols < 64 || image.rows < 64) refuse("the image is smaller than 64 x 64 pixels");
  if (!T_first_this.matrix().allFinite()) refuse("the camera's pose is no number");
}

}  // namespace

View::View(const cv::Mat& image, const Camera& camera, const Eigen::Isometry3d& T_first_this,
           const EdgesParams& params)
    : camera_(camera), T_first_this_(T_first_this) {
  check(image, camera, T_first_this);
  const EdgeMap edges = withoutFields(image, params);
  image_ = edges.image.data == image.data ? image.clone() : edges.image;
  noise_ = edges.noise;
}

}  // namespace planar_bin_picking
