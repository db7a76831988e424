// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 1: image -> EdgeMap.
///
/// Differs from [1] Sec. II-A: edgels are the ridge of the Scharr gradient, kept by a threshold
/// that follows the image's own noise, where they continue along their direction; [1] takes line
/// segments (LSD). Measured in test/benchmark: same candidates, a fraction of the time, and faint
/// edges survive.

#include "image/edge_map.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/params.h"

#include <opencv2/core/mat.hpp>

namespace planar_bin_picking {

/// @param image     8- or 16-bit, one channel, of the camera's size; kept by reference
/// @param radii_px  of each part in the image, in pixels; says at which scale its edges are sought
/// @param threads   >= 1
/// Cost: O(pixels); see test/benchmark.
EdgeMap findEdges(const cv::Mat& image, const Camera& camera, const std::vector<double>& radii_px,
                  const EdgesParams& params, int threads);
/// One field, of the image shrunk to params.megapixels.
EdgeMap findEdges(const cv::Mat& image, const Camera& camera, const EdgesParams& params,
                  int threads);
/// None: the image and its noise alone, for edges sought about a known pose.
EdgeMap withoutFields(const cv::Mat& image, const EdgesParams& params);

}  // namespace planar_bin_picking
