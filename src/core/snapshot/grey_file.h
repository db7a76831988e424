// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Grey pictures as portable graymaps (PGM, binary): lossless, of 8 or 16 bit, and written without
/// a library that would bring along all of OpenCV's file formats.

#include <opencv2/core/mat.hpp>

#include <string>

namespace planar_bin_picking {

/// @param grey  8 or 16 bit, one channel
std::string toPgm(const cv::Mat& grey);

/// @param path  for messages
/// @throws std::runtime_error  no such picture, or cut off
cv::Mat fromPgm(const std::string& bytes, const std::string& path);

}  // namespace planar_bin_picking
