// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A picture of the result for people: outlines of the located parts, their ranks and
/// axes, and dots where something covers them; grey, with the reason, what is not offered.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/part/part_model.h"

#include <opencv2/core/mat.hpp>

#include <memory>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// What is drawn besides the detections; all in the camera's frame.
struct OverlayMore {
  struct Refused {
    Detection detection;
    std::string reason;  ///< a word or two
  };
  std::vector<Refused> refused;
  std::vector<Eigen::Isometry3d> T_camera_pick;        ///< pick poses, z into the part
  std::vector<std::vector<Eigen::Vector3d>> outlines;  ///< of bin and region, closed
  bool has_legend = false;
};

/// @param image       8- or 16-bit, one channel, of the camera's size
/// @param parts       those that Detection::part indexes
/// @return            8-bit BGR of the same size
cv::Mat drawOverlay(const cv::Mat& image, const Camera& camera,
                    const std::vector<std::shared_ptr<const PartModel>>& parts,
                    const std::vector<Detection>& detections, const OverlayMore& more = {});

}  // namespace planar_bin_picking
