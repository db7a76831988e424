// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Marks among the edges: lines that end freely and show where something is, not what it looks
/// like.

#include "drawing/contours.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace planar_bin_picking {

/// Takes centre marks away: straight lines that meet nothing and make a cross, whole or with a gap
/// in its middle, about the centre of an arc or of a closed contour. A line that meets nothing is
/// never an edge, so no edge can be lost.
/// @return  how many lines they were
std::size_t dropCentreMarks(std::vector<Stroke>* strokes, double tolerance);

/// Takes strokes away whose line type says that they are no edges, if they meet nothing at one end:
/// axes on a layer that is kept whatever its line types.
/// @return  how many there were, by line type
std::vector<std::pair<std::string, std::size_t>> dropLooseAnnotation(std::vector<Stroke>* strokes,
                                                                     double tolerance);

}  // namespace planar_bin_picking
