// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part as it was read, for people: a hole on a skipped layer, a wrong unit or a pick pose over a
/// hole is seen at once.

#include "planar_bin_picking/part/part_model.h"

#include <opencv2/core/mat.hpp>

namespace planar_bin_picking {

/// Both faces side by side, each as one sees it when it is up: contours, prints (front), the
/// drawing's origin with x red and y green, the size, and the pick poses for that face with the
/// tool's footprint; below it what describe_part says.
/// @return  8-bit BGR
cv::Mat drawPart(const PartModel& part);

}  // namespace planar_bin_picking
