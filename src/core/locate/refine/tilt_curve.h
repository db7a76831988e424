// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What one picture of a slender part says of each tilt about its length.
///
/// The width that is seen follows the cosine of that tilt, and falls by twice the edge offset. For
/// a width of 12 mm an offset of 0.1 mm is as much as ten degrees, so a single best pose with a
/// Gaussian about it says too much: the cosine is flat at zero, and either sign looks alike. So the
/// other unknowns and the offset are fitted at each of many tilts.

#include "locate/refine/pose_hypothesis.h"
#include "planar_bin_picking/image/camera.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace planar_bin_picking {

/// The best pose at one tilt.
struct TiltPoint {
  Eigen::Isometry3d T_camera_centre;
  double misfit;  ///< half of the residuals' weighted squares, by their variance
  /// Metres by which the edges lie inside the drawn outline, and its standard deviation.
  double offset, offset_sigma;
};

class TiltCurve {
 public:
  /// @param pose  aligned; the curve is of the edges found from there
  /// @param length  of lengthOfSlender
  TiltCurve(const EdgeMap& edges, const Camera& camera, const PoseHypothesis& pose,
            const PartOutline& outline, const Eigen::Vector2d& length);

  /// Tilts between the line of sight and the face's normal about the length, rad: evenly spaced
  /// from -mostTilt() on, so that the middle one is zero.
  const std::vector<TiltPoint>& points() const { return points_; }
  static double tiltOf(std::size_t point);
  std::size_t nearest(double tilt) const;  ///< point
  /// The best pose at a tilt and an edge offset in metres, T_camera_centre.
  Eigen::Isometry3d poseAt(double tilt, double offset) const;
  /// The axis of the tilts, in the centre frame.
  const Eigen::Vector3d& axis() const { return axis_; }

 private:
  using Vector7d = Eigen::Matrix<double, 7, 1>;
  /// One found edge: its residual is J . x - offset_px at the pose where it was found, for x of
  /// pose and edge offset, radii and radians.
  struct Row {
    Vector7d J;
    Eigen::Vector3d at;  // radii
    double offset_px, trust;
  };
  /// Pose and offset at one tilt.
  struct Fit {
    Vector7d x = Vector7d::Zero();
    double squares = 0.0;      // weighted, pixels squared
    double information = 0.0;  // of the offset
  };

  void findRows(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
                const Solid& solid);
  Fit fitAt(double turn, Fit from, double offset, double offset_held) const;
  TiltPoint pointOf(const Fit& fit, double tilt) const;
  Eigen::Isometry3d poseOf(const Fit& fit, double turn) const;

  Eigen::Isometry3d T_;  // T_camera_centre where the edges were found
  double radius_ = 0.0, offset_ = 0.0, to_sight_ = 0.0, variance_ = 1.0;
  Eigen::Vector3d axis_;
  std::vector<Row> rows_;
  std::vector<TiltPoint> points_;
  std::vector<Fit> fits_;
};

}  // namespace planar_bin_picking
