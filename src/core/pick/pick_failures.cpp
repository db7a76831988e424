// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/pick_failures.h"

#include <algorithm>

namespace planar_bin_picking {

void PickFailures::use(double same_place, double changed_grey) {
  same_place_ = same_place;
  changed_grey_ = changed_grey;
}

bool PickFailures::isAt(const Failure& failure, const PickInstance& instance, double reach) const {
  return failure.part == instance.part && (failure.center - instance.center).norm() <= reach;
}

auto PickFailures::find(const PickInstance& instance) -> std::vector<Failure>::iterator {
  return std::find_if(failures_.begin(), failures_.end(),
                      [&](const Failure& f) { return isAt(f, instance, same_place_); });
}

void PickFailures::add(const PickInstance& instance) {
  const auto known = find(instance);
  if (known == failures_.end()) {
    failures_.push_back({instance.part, instance.center, instance.surroundings, 1, false});
    return;
  }
  ++known->count;
  known->surroundings = instance.surroundings;
}

void PickFailures::remove(const PickInstance& picked) {
  const auto was_its_own = [&](const Failure& f) {
    return isAt(f, picked, same_place_) || (f.has_gone && isAt(f, picked, picked.radius));
  };
  failures_.erase(std::remove_if(failures_.begin(), failures_.end(), was_its_own), failures_.end());
}

int PickFailures::recall(const PickInstance& instance) {
  const auto known = find(instance);
  if (known == failures_.end()) return 0;
  if (difference(known->surroundings, instance.surroundings) <= changed_grey_) return known->count;
  failures_.erase(known);
  return 0;
}

std::vector<std::size_t> PickFailures::moved(const std::vector<PickInstance>& instances) {
  std::vector<bool> has_moved(instances.size(), false);
  for (Failure& failure : failures_) {
    failure.has_gone = std::none_of(instances.begin(), instances.end(), [&](const PickInstance& i) {
      return isAt(failure, i, same_place_);
    });
    for (std::size_t i = 0; i < instances.size() && failure.has_gone; ++i)
      has_moved[i] = has_moved[i] || isAt(failure, instances[i], instances[i].radius);
  }
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < has_moved.size(); ++i)
    if (has_moved[i]) out.push_back(i);
  return out;
}

}  // namespace planar_bin_picking
