// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Points of an outline in the directional distance field, several at a time.

#include "image/edge_map.h"
#include "part/outline_view.h"

#include <array>
#include <vector>

namespace planar_bin_picking {

/// The points by component, as in LocalPoint.
struct FieldPoints {
  static constexpr int kLanes = 16;
  int count = 0;
  std::vector<double> x, y, tx, ty;  ///< to a multiple of kLanes: the last point fills the rest

  FieldPoints() = default;
  FieldPoints(const std::vector<LocalPoint>& points);  // NOLINT: the same points
};

/// What a block of posed points sees of the field.
struct FieldBlock {
  static constexpr int kMost = 64;
  template <class T>
  using Lanes = std::array<T, kMost>;
  int count = 0;                ///< lanes that are set, a multiple of FieldPoints::kLanes
  Lanes<double> is_real;        ///< 1, or 0 for what fills up the last lanes
  Lanes<double> is_inside;      ///< 1 within the field, else 0
  Lanes<double> iu, iv, inv_z;  ///< ideal image plane
  Lanes<double> a, b;           ///< within the pixel, 0..1
  Lanes<int> place;             ///< of the pixel, in Field::distance
  Lanes<int> bin;               ///< of the direction; kept as long as it is not renewed
  Lanes<double> d, gx, gy;      ///< distance and its slope, field pixels and per field pixel
};

/// Blocks that all points take.
inline int blocksOf(const FieldPoints& points) {
  return (points.count + FieldBlock::kMost - 1) / FieldBlock::kMost;
}

/// One block of points at a pose.
/// @param renew_bins  false: the block holds those of a pose nearby
void look(const Field& field, const FieldPoints& points, double radius,
          const Eigen::Isometry3d& T_camera_centre, int block, bool renew_bins, FieldBlock* out);

}  // namespace planar_bin_picking
