// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/pick_order.h"

#include <algorithm>
#include <numeric>

namespace planar_bin_picking {

double points(const PickPlace& place, const PickOrder& order) {
  const Eigen::Vector3d point(order.near_x, order.near_y, order.near_z);
  return place.rank + order.height * place.height -
         order.near * (place.center_target - point).norm() +
         order.walls * std::min(place.wall_distance, kWallFarthest) - order.clockwise * place.turn;
}

std::vector<std::size_t> ordered(const std::vector<PickPlace>& places, const PickOrder& order,
                                 const bool is_ranked) {
  std::vector<std::size_t> indices(places.size());
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  if (is_ranked && order.isRank()) return indices;
  std::stable_sort(indices.begin(), indices.end(), [&](const std::size_t a, const std::size_t b) {
    return points(places[a], order) > points(places[b], order);
  });
  return indices;
}

}  // namespace planar_bin_picking
