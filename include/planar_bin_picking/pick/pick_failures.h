// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Where picks failed, and whether the scene there is as it was: a small picture of the
/// surroundings is kept with each failure and held against the new image.

#include "planar_bin_picking/pick/surroundings.h"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// An instance of a part, as far as failures are concerned.
struct PickInstance {
  const std::string& part;
  const Eigen::Vector3d& center;  ///< of the face, metres, in the answer's frame
  double radius;                  ///< of the part, metres; 0 = unknown
  const Surroundings& surroundings;
};

/// Not thread-safe.
class PickFailures {
 public:
  /// An instance nearer than `same_place` (metres) is the one that failed, and a mean difference of
  /// its surroundings above `changed_grey` (levels of 8 bits) a changed scene.
  void use(double same_place, double changed_grey);

  void add(const PickInstance& instance);
  /// What was picked does not fail again, be it where it failed or where it was dragged to.
  void remove(const PickInstance& picked);

  /// How often picks failed there in the scene as it is; forgets them where it has changed.
  int recall(const PickInstance& instance);
  /// Indices, ascending, of those that have moved since a pick failed, as a robot drags aside what
  /// it cannot hold: of each failure at which none of them is now, the nearest within its radius.
  /// @param instances  all that was seen
  /// Cost: O(instances * failures).
  std::vector<std::size_t> moved(const std::vector<PickInstance>& instances);

 private:
  struct Failure {
    std::string part;
    Eigen::Vector3d center;
    Surroundings surroundings;
    int count;
    std::optional<Eigen::Vector3d> moved_to;  ///< where it was last seen, if not at its place
  };
  bool isAt(const Failure& failure, const PickInstance& instance) const;
  bool hasMovedTo(const Failure& failure, const PickInstance& instance) const;
  std::vector<Failure>::iterator find(const PickInstance& instance);

  double same_place_ = 0.0, changed_grey_ = 0.0;
  std::vector<Failure> failures_;
};

}  // namespace planar_bin_picking
