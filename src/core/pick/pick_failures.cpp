// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/pick_failures.h"

#include <algorithm>
#include <set>

namespace planar_bin_picking {

void PickFailures::use(double same_place, double changed_grey) {
  same_place_ = same_place;
  changed_grey_ = changed_grey;
}

bool PickFailures::isAt(const Failure& failure, const PickInstance& instance) const {
  return failure.part == instance.part && (failure.center - instance.center).norm() <= same_place_;
}

bool PickFailures::hasMovedTo(const Failure& failure, const PickInstance& instance) const {
  return failure.part == instance.part && failure.moved_to &&
         (*failure.moved_to - instance.center).norm() <= same_place_;
}

auto PickFailures::find(const PickInstance& instance) -> std::vector<Failure>::iterator {
  return std::find_if(failures_.begin(), failures_.end(),
                      [&](const Failure& f) { return isAt(f, instance); });
}

void PickFailures::add(const PickInstance& instance) {
  const auto known = find(instance);
  if (known != failures_.end()) {
    ++known->count;
    known->surroundings = instance.surroundings;
    return;
  }
  failures_.erase(std::remove_if(failures_.begin(), failures_.end(),
                                 [&](const Failure& f) { return hasMovedTo(f, instance); }),
                  failures_.end());
  failures_.push_back({instance.part, instance.center, instance.surroundings, 1, {}});
}

void PickFailures::remove(const PickInstance& picked) {
  const auto was_its_own = [&](const Failure& f) {
    return isAt(f, picked) || hasMovedTo(f, picked);
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
  std::set<std::size_t> out;
  for (Failure& failure : failures_) {
    // Where a call was for other parts, it is where it was.
    if (std::none_of(instances.begin(), instances.end(),
                     [&](const PickInstance& i) { return i.part == failure.part; }))
      continue;
    failure.moved_to.reset();
    if (std::any_of(instances.begin(), instances.end(),
                    [&](const PickInstance& i) { return isAt(failure, i); }))
      continue;
    std::optional<std::size_t> nearest;
    double least = 0.0;
    for (std::size_t i = 0; i < instances.size(); ++i) {
      const double off = (instances[i].center - failure.center).norm();
      if (instances[i].part != failure.part || off > instances[i].radius) continue;
      if (nearest && off >= least) continue;
      nearest = i;
      least = off;
    }
    if (!nearest) continue;
    failure.moved_to = instances[*nearest].center;
    out.insert(*nearest);
  }
  return {out.begin(), out.end()};
}

}  // namespace planar_bin_picking
