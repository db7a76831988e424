// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Known poses of the parts in one picture, to compare an answer with. For parts without symmetry.

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace planar_bin_picking_ros {

struct TruthTolerance {
  double lateral = 0.0, depth = 0.0;  ///< metres, across and along the line of sight
  double angle = 0.0;                 ///< rad, between the rotations
};

class Truth {
 public:
  /// @throws YAML::Exception  the file is not as test/data/*/truth.yaml
  explicit Truth(const std::string& path);

  /// Whether a part lies there that no earlier call has taken; takes it.
  bool take(const std::string& part, bool front, const Eigen::Isometry3d& T_camera_part,
            const TruthTolerance& tolerance);

  int pickable() const;       ///< how many parts nothing covers
  int pickableTaken() const;  ///< how many of these were taken

 private:
  struct Instance {
    std::string part;
    bool front = true;
    double visible = 0.0;
    Eigen::Isometry3d T_camera_part = Eigen::Isometry3d::Identity();
    bool taken = false;
    bool pickable() const { return visible >= 0.95; }
  };

  std::vector<Instance> instances_;
  Eigen::Vector3d center_;  ///< of the part, where position is compared
};

}  // namespace planar_bin_picking_ros
