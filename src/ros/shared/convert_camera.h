// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Messages of a camera -> the core's types; pure functions. What a message may get wrong is
/// refused here, with a Refusal that names the topic's field and the remedy.

#include "planar_bin_picking/image/camera.h"

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core/mat.hpp>

namespace planar_bin_picking_ros {

/// The grey values of an image of any 8- or 16-bit mono, colour, Bayer or YUV encoding, in its
/// depth. A mono image is not copied: the result shares the message's data and keeps the message
/// alive only as long as the caller keeps it. 8UC3 and 8UC4 are taken as blue, green, red, as
/// OpenCV has them.
/// @throws Refusal  BAD_IMAGE: empty, another encoding, fewer data than its size needs, no frame
cv::Mat toGrey(const sensor_msgs::ImageConstPtr& image);

/// The camera of one image: its CameraInfo with region of interest and binning taken into account.
/// @throws Refusal  BAD_CAMERA_INFO: not calibrated, another size than the image, or refused by
/// Camera
planar_bin_picking::Camera toCamera(const sensor_msgs::CameraInfo& info,
                                    const sensor_msgs::Image& image);

}  // namespace planar_bin_picking_ros
