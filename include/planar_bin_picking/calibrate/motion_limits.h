// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Where the robot may be and how it gets there: a box, planes, a cone, a turn about the flange's
/// own axis, and the largest step.
///
/// A pose is described against the start by its place, the tilt of the flange's z axis (a rotation
/// vector about an axis in the start's x-y plane) and the roll about that axis. In these six
/// numbers box, cone and roll are convex, so that a straight line between two allowed poses stays
/// allowed, where a turn about one fixed axis may leave the cone. Between two poses of a way the
/// robot is expected to go straight and to turn about one fixed axis, as MoveRobot demands; each
/// such piece is checked, too.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct MotionParams {
  /// Metres, in the base frame; all zero = not set, which is refused.
  double workspace_min_x = 0.0, workspace_min_y = 0.0, workspace_min_z = 0.0;
  double workspace_max_x = 0.0, workspace_max_y = 0.0, workspace_max_z = 0.0;
  /// Four numbers for each plane, nx ny nz d: allowed is n * x >= d.
  std::vector<double> planes;
  double cone_deg = 45.0;  ///< the flange's z axis stays within this of where it was at the start
  double max_roll_deg = 90.0;     ///< about that axis, either way from the start: camera cables
  double max_step_m = 0.1;        ///< from pose to pose; larger moves get poses in between
  double max_turn_deg = 15.0;     ///< likewise
  double mounted_radius_m = 0.3;  ///< what is mounted on the flange lies within this of its origin
  double clearance_m = 0.03;      ///< that camera and board keep once their places are known

  /// Calls visit(key, member, min, max) for all but the planes.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("workspace_min_x", self.workspace_min_x, -100.0, 100.0);
    visit("workspace_min_y", self.workspace_min_y, -100.0, 100.0);
    visit("workspace_min_z", self.workspace_min_z, -100.0, 100.0);
    visit("workspace_max_x", self.workspace_max_x, -100.0, 100.0);
    visit("workspace_max_y", self.workspace_max_y, -100.0, 100.0);
    visit("workspace_max_z", self.workspace_max_z, -100.0, 100.0);
    visit("cone_deg", self.cone_deg, 5.0, 180.0);
    visit("max_roll_deg", self.max_roll_deg, 5.0, 180.0);
    visit("max_step_m", self.max_step_m, 0.005, 10.0);
    visit("max_turn_deg", self.max_turn_deg, 1.0, 90.0);
    visit("mounted_radius_m", self.mounted_radius_m, 0.0, 10.0);
    visit("clearance_m", self.clearance_m, 0.0, 10.0);
  }
};

/// @throws std::invalid_argument  a field out of its range, no workspace or an empty one, a plane
/// without direction: key, value, remedy
void validate(const MotionParams& params);

/// What the flange carries: each point may be `margin` away from where it is said to be.
struct Mounted {
  std::vector<Eigen::Vector3d> points{Eigen::Vector3d::Zero()};  ///< in the flange's frame
  double margin = 0.0;                                           ///< metres
};

class MotionLimits {
 public:
  /// Nothing is known of what is mounted yet: it may be anywhere within mounted_radius_m.
  /// @throws std::invalid_argument  bad params; the start itself is not allowed: why
  MotionLimits(const MotionParams& params, const Eigen::Isometry3d& T_base_start);

  void setMounted(const Mounted& mounted) { mounted_ = mounted; }
  const Mounted& mounted() const { return mounted_; }

  /// "" where the robot may be; else what leaves what.
  std::string whyNot(const Eigen::Isometry3d& T_base_flange) const;
  bool allows(const Eigen::Isometry3d& T_base_flange) const;
  /// Allowed with some distance left, for the robot's own inaccuracy and the way there.
  bool allowsTarget(const Eigen::Isometry3d& T_base_flange) const;

  /// One piece of a way: not too large, and all of it allowed.
  bool allowsStep(const Eigen::Isometry3d& T_base_from, const Eigen::Isometry3d& T_base_to) const;

  /// @return  the poses to go to one after the other, the last one `T_base_there`; none of the
  /// steps is too large, and all of each is allowed. Nothing where no such way is found; empty
  /// where the robot stands there already
  std::optional<std::vector<Eigen::Isometry3d>> way(const Eigen::Isometry3d& T_base_here,
                                                    const Eigen::Isometry3d& T_base_there) const;

 private:
  /// What may be left of a limit, metres and radians.
  struct Keep {
    double metres, radians;
  };
  std::string whyNot(const Eigen::Isometry3d& T_base_flange, const Keep& keep) const;
  std::string whyNotAt(const Eigen::Vector3d& x_base, double keep) const;
  std::optional<std::vector<Eigen::Isometry3d>> wayOf(const Eigen::Isometry3d& T_base_here,
                                                      const Eigen::Isometry3d& T_base_there,
                                                      int steps) const;

  const MotionParams params_;
  const Eigen::Isometry3d T_base_start_;
  Mounted mounted_;
};

}  // namespace planar_bin_picking
