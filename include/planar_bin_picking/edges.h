// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 1: image -> EdgeMap.
///
/// Differs from [1] Sec. II-A: edgels are the ridge of the Scharr gradient, kept by a threshold
/// that follows the image's own noise, where they continue along their direction; [1] takes line
/// segments (LSD). Measured in test/benchmark: same candidates, a fraction of the time, and faint
/// edges survive.

#include "planar_bin_picking/camera.h"
#include "planar_bin_picking/edge_map.h"

#include <opencv2/core/mat.hpp>

namespace planar_bin_picking {

struct EdgesParams {
  double noise_factor = 4.0;  ///< an edgel's gradient is at least this many times its noise
  /// An edgel weaker than this many times the mean gradient about it may be texture ...
  double texture_factor = 2.0;
  double texture_cost_px = 1.33;  ///< ... and counts as so many field pixels farther
  double megapixels = 1.3;        ///< edges are sought in the image shrunk to about this size
  /// A part whose radius has more pixels than this is sought in an image that is shrunk until it
  /// has about so many: noise and the texture of floors average out, its outline does not.
  double radius_px = 110.0;
  double direction_cost_px = 1.0;  ///< field pixels that one direction bin off counts as

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("noise_factor", self.noise_factor, 1.0, 50.0);
    visit("texture_factor", self.texture_factor, 0.0, 20.0);
    visit("texture_cost_px", self.texture_cost_px, 0.0, 20.0);
    visit("megapixels", self.megapixels, 0.1, 50.0);
    visit("radius_px", self.radius_px, 20.0, 1000.0);
    visit("direction_cost_px", self.direction_cost_px, 0.0, 20.0);
  }
};

/// @param image     8- or 16-bit, one channel, of the camera's size; kept by reference
/// @param radii_px  of each part in the image, in pixels; says at which scale its edges are sought
/// @param threads   >= 1
/// Cost: O(pixels); see test/benchmark.
EdgeMap findEdges(const cv::Mat& image, const Camera& camera, const std::vector<double>& radii_px,
                  const EdgesParams& params, int threads);
/// One field, of the image shrunk to params.megapixels.
EdgeMap findEdges(const cv::Mat& image, const Camera& camera, const EdgesParams& params,
                  int threads);

}  // namespace planar_bin_picking
