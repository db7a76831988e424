// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One call's result and what it was found in: all that is published about it.

#include "input/image_inbox.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locator.h"

#include <planar_bin_picking/LocatedPart.h>
#include <std_msgs/Header.h>

#include <opencv2/core/mat.hpp>

#include <vector>

namespace planar_bin_picking_ros {

struct Answer {
  std::vector<planar_bin_picking::PartPtr> parts;  ///< that were looked for
  Frame frame;                                     ///< keeps the data of `grey` alive
  cv::Mat grey;
  planar_bin_picking::Camera camera;
  planar_bin_picking::LocateResult result;
  std_msgs::Header header;                               ///< stamp of the image, target frame
  std::vector<planar_bin_picking::LocatedPart> located;  ///< best first
};

}  // namespace planar_bin_picking_ros
