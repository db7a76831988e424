// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Contours that were left out of a drawing, held against what was read as edges.

#include "drawing/contours.h"
#include "drawing/edge_selection.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

/// Whether a rule of the default list took the part's outline or its holes away.
/// @param contours  of what is read as edges, closed, that do not cross
/// @param warnings  gets what was left out and might have been a hole, or a frame
/// @throws std::runtime_error  a closed contour around all edges was left out that may be the
/// outline
void checkPassedOver(const EdgeSelection& selection, const std::vector<Contour>& contours,
                     double tolerance, std::vector<std::string>* warnings);

}  // namespace planar_bin_picking
