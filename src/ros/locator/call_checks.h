// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a call of LocatePart has to obey, besides what the stages themselves ask for.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locate_request.h"

#include <planar_bin_picking/LocatePart.h>
#include <sensor_msgs/Image.h>

#include <cstdint>
#include <string>

namespace planar_bin_picking_ros {

/// @throws Refusal  BAD_REQUEST: no such face
planar_bin_picking::FaceFilter faceFilter(std::uint8_t face);

/// @throws Refusal  BAD_REQUEST: a time that no image can meet
void checkTimes(const planar_bin_picking::LocatePart::Request& request);

/// @throws Refusal  BAD_IMAGE: too small
void checkSize(const sensor_msgs::Image& image);

/// Takes out parts that cannot be located in such a picture.
/// @return  what is wrong with them; "" where nothing is
/// @throws Refusal  BAD_PART_SIZE: none is left
std::string dropUnsuitable(const planar_bin_picking::Camera& camera,
                           planar_bin_picking::LocateRequest* request);

}  // namespace planar_bin_picking_ros
