// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a camera model is one that a calibration finds: a wrong one locates parts all the same,
/// at wrong places.

#include "planar_bin_picking/image/camera.h"

#include <array>

namespace planar_bin_picking {

/// Size, focal lengths and principal point.
/// @throws std::invalid_argument  the first that makes no sense: field, value, what it must be
void checkPinhole(const Camera::Model& model);

/// The coefficients in OpenCV's order, zeros where there are fewer.
/// @throws std::invalid_argument  unknown model, too many coefficients, or one that is not finite
std::array<double, 8> checkedCoefficients(const Camera::Model& model);

/// The distortion over the image: one-to-one, and no farther from a pinhole than lenses are.
/// @throws std::invalid_argument  naming the pixel
void checkLens(const Camera& camera);

}  // namespace planar_bin_picking
