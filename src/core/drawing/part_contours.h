// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Contours as they were chained -> the loops of one part. Lengths in mm.

#include "drawing/contours.h"
#include "planar_bin_picking/drawing/drawing.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace planar_bin_picking {

/// Drops points that lie on each other, and spikes and small loops that the path runs through on
/// its way, as long as they are shorter than the tolerance.
void smooth(Contour* contour, double tolerance);

Eigen::AlignedBox2d boxOf(const std::vector<Eigen::Vector2d>& points);
/// `from (0.000, 0.000) mm to (10.000, 5.000) mm`
std::string boxText(const std::vector<Eigen::Vector2d>& points);

/// @throws std::runtime_error  contours that cross or touch; a size that no part has
void checkCrossings(const std::vector<Contour>& contours);
void checkSize(const std::vector<Contour>& contours);

/// The outer contour first, the holes after it in their order.
/// @throws std::runtime_error  several outer contours, or contours in holes
std::vector<Loop> classify(const std::vector<Contour>& contours);

}  // namespace planar_bin_picking
