// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A bin that may stand otherwise than it is said to, found again by its rim: a flat frame whose
/// outline follows from the bin's size, which the locator looks for as for any part. A rectangle
/// looks the same from two sides; the one nearest to where the bin is said to stand counts.

#include "planar_bin_picking/bin/floor_cover.h"
#include "planar_bin_picking/locate/locator.h"

#include <optional>

namespace planar_bin_picking {

struct BinSearch {
  BinBox told;  ///< where it is said to stand
  /// Metres, of the walls on top, > 0. Of the inner edge alone nobody could say whether it is the
  /// outer one of a bin that stands nearer.
  double wall = 0.0;
  /// What is farther off is found, and not within the limits: of the rim's middle, metres; about
  /// the bin's z; of the rim's plane.
  double moved_max = 0.06, turned_max_deg = 10.0, tilted_max_deg = 5.0;
};

struct FoundBin {
  Eigen::Isometry3d T_told_found = Eigen::Isometry3d::Identity();  ///< both are bin frames
  double moved = 0.0;  ///< metres, of the middle of the rim
  double turned_deg = 0.0, tilted_deg = 0.0;
  double score = 0.0;
  bool is_within = false;  ///< the limits
};

/// How far that is from where it is said to stand; score 0.
FoundBin foundAt(const BinSearch& search, const Eigen::Isometry3d& T_told_found);

/// The rim as a part: its z = 0 is the bin's top, its x and y are the bin's.
/// @throws std::invalid_argument  a box without a size, walls without one
PartFile rimOf(const BinSearch& search);

/// @return  the best that is within the limits, or else the best; nothing where no rim is seen
/// @throws PartSizeError          the rim does not fit into the picture
/// @throws std::invalid_argument  as Locator::locate
/// Cost: that of locating one part.
std::optional<FoundBin> findBin(const cv::Mat& image, const Camera& camera, const BinSearch& search,
                                const Locator& locator);

}  // namespace planar_bin_picking
