// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a pick pose can be what its user meant: a sign or a unit that is wrong sends the tool
/// the wrong way.

#include "planar_bin_picking/part/part_file.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

/// @return  what is wrong with the pose's z, and the remedy; empty where it points into the part
///          for every face that the pose applies to
std::string wrongDirection(const PickPose& pose);

/// @return  about poses that touch nothing but air, or more than the part has there
std::vector<std::string> pickWarnings(const PartFile& part);

}  // namespace planar_bin_picking
