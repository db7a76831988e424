// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Which of the parts that can be picked comes first, where a cell wants another order than that of
/// the rank: the highest, the nearest to a point, the farthest from the walls, clockwise, or a
/// mixture of them.
///
/// Each part gets points, and the one with the most comes first: confirmed * visible share^2 (the
/// rank, at most 1 point), and for each metre as many as its weight says.

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace planar_bin_picking {

struct PickOrder {
  double height =
      0.0;            ///< points per metre that a part lies higher (z of the bin, or of the answer)
  double near = 0.0;  ///< points per metre that it lies nearer to the point
  double near_x = 0.0, near_y = 0.0, near_z = 0.0;  ///< the point, metres, in the answer's frame
  double walls = 0.0;  ///< points per metre from the nearest wall, up to 0.1 m
  /// Points that the first has over the last, clockwise about the bin's middle as one looks in,
  /// from the bin's y axis on.
  double clockwise = 0.0;

  bool isRank() const { return height == 0.0 && near == 0.0 && walls == 0.0 && clockwise == 0.0; }
};

/// Farther from the walls nothing is won: no tool is so wide.
inline constexpr double kWallFarthest = 0.1;  // metres

/// What the order looks at of a part.
struct PickPlace {
  double rank = 0.0;  ///< confirmed * visible share^2, less where it may be held down
  Eigen::Vector3d center_target = Eigen::Vector3d::Zero();
  double height = 0.0;         ///< metres
  double wall_distance = 0.0;  ///< metres; 0 without a bin
  double turn = 0.0;           ///< of a full turn, 0..1, clockwise; 0 without a bin
};

double points(const PickPlace& place, const PickOrder& order);

/// Indices, most points first; parts with as many stay as given, and so do all where no weight is
/// set.
/// @param is_ranked  they are given by their rank
std::vector<std::size_t> ordered(const std::vector<PickPlace>& places, const PickOrder& order,
                                 bool is_ranked = true);

}  // namespace planar_bin_picking
