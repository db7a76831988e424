// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Status and message of a call that got as far as looking at the image.

#include "locator/settings/cell_params.h"
#include "planar_bin_picking/bin/floor_cover.h"
#include "planar_bin_picking/locate/locate_request.h"

#include <planar_bin_picking/LocatePart.h>

#include <string>

namespace planar_bin_picking_ros {

struct Look {
  const planar_bin_picking::LocateRequest& request;
  const planar_bin_picking::Report& report;
  double threshold = 0.0;  ///< score from which on a part is found
  std::string hint;        ///< what to do where all were refused
  const CellParams& cell;
  planar_bin_picking::FloorCover cover;  ///< not known without a bin
};

/// EMPTY in place of NO_PART_FOUND only where the picture leaves no doubt.
/// @param response  has the offered and the refused parts in it
void conclude(const Look& look, planar_bin_picking::LocatePart::Response* response);

}  // namespace planar_bin_picking_ros
