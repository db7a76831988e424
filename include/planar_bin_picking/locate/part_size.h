// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether a part can be located in the pictures of a camera at all.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/part/part_model.h"

#include <stdexcept>

namespace planar_bin_picking {

/// A part that cannot be located in such a picture: by far too small or too large for it, as with a
/// drawing in the wrong unit. The text has both sizes, in mm and pixels, and the remedy.
class PartSizeError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// @throws PartSizeError          the part has fewer than 56 x 8 pixels even at distance_min, or
///         does not fit into the view even at distance_max
/// @throws std::invalid_argument  as checkDistances
void checkPartSize(const PartModel& part, const Camera& camera, double distance_min,
                   double distance_max);

}  // namespace planar_bin_picking
