// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Pictures of parts as files.

#include "planar_bin_picking/show/part_picture.h"

#include <opencv2/imgcodecs.hpp>

#include <stdexcept>
#include <string>

namespace planar_bin_picking {

/// @throws std::runtime_error  the path and what may be wrong with it
inline void writePartPicture(const std::string& path, const PartModel& part) {
  bool is_written = false;
  try {
    is_written = cv::imwrite(path, drawPart(part));
  } catch (const cv::Exception& error) {
    throw std::runtime_error(path + ": cannot be written: " + error.err);
  }
  if (!is_written)
    throw std::runtime_error(path +
                             ": cannot be written; check the folder, its permissions and the disk");
}

}  // namespace planar_bin_picking
