// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The picture about a part, kept with a failed pick, to tell in a later image whether the scene
/// there has changed.

#include "planar_bin_picking/image/camera.h"

#include <opencv2/core/mat.hpp>

namespace planar_bin_picking {

/// See cutSurroundings.
struct Surroundings {
  cv::Mat patch;  ///< float, in the image's own grey levels, its mean taken off; may be empty
  int bits = 8;   ///< that the whole image used (grey.h)
};

/// The image that parts were found in.
struct PickScene {
  const cv::Mat& grey;
  int bits;  ///< bitsInUse(grey)
  const Camera& camera;
};

/// A small picture of a part and what lies about it: its mean taken away, so that the lamp's
/// brightness does not count. Empty where the part is not wholly in the image.
/// @param center, radius  of the part's outline, part frame, metres
Surroundings cutSurroundings(const PickScene& scene, const Eigen::Isometry3d& T_camera_part,
                             const Eigen::Vector3d& center, double radius);

/// Mean absolute difference, grey levels of 256, whatever the images' depth; 0 where there is
/// nothing to compare: nothing tells of a change then.
double difference(const Surroundings& a, const Surroundings& b);

}  // namespace planar_bin_picking
