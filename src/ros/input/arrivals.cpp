// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "input/arrivals.h"

#include <algorithm>
#include <chrono>

namespace planar_bin_picking_ros {

double between(const ros::Time& earlier, const ros::Time& later) {
  return static_cast<double>(later.sec) - earlier.sec +
         1e-9 * (static_cast<double>(later.nsec) - earlier.nsec);
}

void Arrivals::note(const ros::Time& stamp, const SteadyTime received) {
  latest_[1] = latest_[0];
  latest_[0] = {stamp, received};
  ++count_;
}

double Arrivals::lead(const Arrivals& other, const SteadyTime since) const {
  auto closest = std::chrono::steady_clock::duration::max();
  double lead = 0.0;
  for (std::size_t i = 0; i < std::min(count_, latest_.size()); ++i) {
    for (std::size_t j = 0; j < std::min(other.count_, latest_.size()); ++j) {
      if (latest_[i].received < since || other.latest_[j].received < since) continue;
      const auto apart = std::chrono::abs(latest_[i].received - other.latest_[j].received);
      if (apart >= closest) continue;
      closest = apart;
      lead = between(latest_[i].stamp, other.latest_[j].stamp);
    }
  }
  return lead;
}

}  // namespace planar_bin_picking_ros
