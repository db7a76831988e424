// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part as a body made of triangles, for viewers.

#include "planar_bin_picking/part/part_model.h"

#include <vector>

namespace planar_bin_picking {

/// Both faces and the walls between them; contours are simplified to what an eye sees of them.
/// @return  three corners of each triangle in turn, part frame, counter-clockwise as seen from
///          outside. Of a part whose thickness is not known, the one face.
std::vector<Eigen::Vector3d> solidTriangles(const PartModel& part);

}  // namespace planar_bin_picking
