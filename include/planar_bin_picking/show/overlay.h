// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A picture of the result for people: outlines of the located parts, their ranks and
/// axes, and dots where something covers them.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/part/part_model.h"

#include <opencv2/core/mat.hpp>

#include <memory>
#include <vector>

namespace planar_bin_picking {

/// @param image       8- or 16-bit, one channel, of the camera's size
/// @param parts       those that Detection::part indexes
/// @return            8-bit BGR of the same size
cv::Mat drawOverlay(const cv::Mat& image, const Camera& camera,
                    const std::vector<std::shared_ptr<const PartModel>>& parts,
                    const std::vector<Detection>& detections);

}  // namespace planar_bin_picking
