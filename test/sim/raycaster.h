// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Which body a ray meets first: Embree over the bodies of the cell.

#include "sim/solid.h"

#include <memory>
#include <optional>
#include <vector>

namespace planar_bin_picking::cell {

struct Hit {
  int body = -1;          ///< index of the instance, in the order of `place`
  float distance = 0.0f;  ///< along the ray, in lengths of its direction
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, out of the body, base frame
};

/// One thing in the cell: which mesh, and where.
struct Instance {
  int mesh = 0;
  Eigen::Isometry3d T_base_body = Eigen::Isometry3d::Identity();
};

class Raycaster {
 public:
  explicit Raycaster(const std::vector<Mesh>& meshes);
  ~Raycaster();
  Raycaster(const Raycaster&) = delete;
  Raycaster& operator=(const Raycaster&) = delete;

  /// Puts these bodies, and no others, into the cell.
  void place(const std::vector<Instance>& instances);

  /// Safe to call from several threads, as is blocked().
  std::optional<Hit> cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                          float near, float far) const;
  bool blocked(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near,
               float far) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace planar_bin_picking::cell
