// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One picture of the scene, and where the camera was. All views of a part are placed against the
/// first, in which the part was located.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/params.h"

#include <opencv2/core/mat.hpp>

#include <array>
#include <memory>

namespace planar_bin_picking {

/// Immutable; holds a copy of the picture with 8 bits, so that a view may be kept for later looks.
class View {
 public:
  /// @param image         8- or 16-bit, one channel, of the camera's size
  /// @param T_first_this  this camera's frame -> that of the first view; the identity for the first
  /// @throws std::invalid_argument  image empty, of another type or size; a pose that is no number
  View(const cv::Mat& image, const Camera& camera, const Eigen::Isometry3d& T_first_this,
       const EdgesParams& params = {});

  const cv::Mat& image() const { return image_; }  ///< 8 bit
  const Camera& camera() const { return camera_; }
  const Eigen::Isometry3d& T_first_this() const { return T_first_this_; }
  /// As EdgeMap::noise.
  const std::array<float, 256>& noise() const { return noise_; }

 private:
  cv::Mat image_;
  Camera camera_;
  Eigen::Isometry3d T_first_this_;
  std::array<float, 256> noise_{};
};

using ViewPtr = std::shared_ptr<const View>;

}  // namespace planar_bin_picking
