// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Motions of an outline within its plane under which most of it stays on itself: a bar along its
/// length, and nearer or farther.
///
/// The edges of the long sides hold an alignment wherever it began along them, since the few points
/// at the ends and the holes, which alone tell, see the edges of others there. So these motions are
/// searched through, by the telling points, in the distance field.

#include "locate/align/field_points.h"

#include <vector>

namespace planar_bin_picking {

struct SlidPose {
  Eigen::Isometry3d T_camera_centre;
  double score;  ///< of the telling points, 0..1
};

class Slides {
 public:
  Slides() = default;
  /// @param shape  points of the outline, evenly spaced
  explicit Slides(const std::vector<LocalPoint>& shape);

  bool empty() const { return motions_.empty(); }

  /// Poses along the slides at which most telling points lie on edgels, the best first, each apart
  /// from the others and from the start.
  /// @param radius  of the part, metres
  /// Cost: 0.5 ms for a bar of 300 field pixels.
  std::vector<SlidPose> peaks(const Field& field, double radius,
                              const Eigen::Isometry3d& T_camera_centre, std::size_t count) const;

 private:
  struct Motion {
    Eigen::Vector4d direction;  // x, y in radii, turn in rad, relative size
    double most;                // amount to either side
    double fastest;             // radii by which any point moves at most, per amount
  };
  std::vector<Motion> motions_;
  FieldPoints telling_;
};

}  // namespace planar_bin_picking
