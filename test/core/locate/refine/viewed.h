// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "locate/refine/hypotheses.h"

#include "part/visible_face.h"
#include "support/stages.h"

namespace planar_bin_picking {

inline constexpr double kMetres = 1e-3, kRadians = 1.5 * kDegrees;

/// Half the bracket: so small that its picture hardly tells the sign of the tilt.
inline sim::Plate smallBracket(double thickness_mm = 0.0, double scale = 0.5) {
  sim::Plate plate = bracketPlate();
  for (auto& p : plate.outer) p *= scale;
  for (auto& hole : plate.holes)
    for (auto& p : hole) p *= scale;
  plate.thickness_mm = thickness_mm;
  return plate;
}

/// 60 x 40 mm: the one hole alone tells it from its half turn and from its other face.
inline sim::Plate oneHolePlate() {
  return {rectangle(-30, -20, 30, 20), {circle(17, 9, 4, true)}, {}, 0.0};
}

/// Near the optical axis, where tilts of either sign look most alike.
inline Eigen::Isometry3d tilted(double tilt_deg, double yaw_deg = 20.0, bool front = true) {
  return sim::poseOf({0, 0, 600, yaw_deg, tilt_deg, 70, front});
}

/// About the part's z.
inline Eigen::Isometry3d turned(const Eigen::Isometry3d& T_camera_part, double degrees) {
  return T_camera_part * Eigen::AngleAxisd(degrees * kDegrees, Eigen::Vector3d::UnitZ());
}

inline Eigen::Vector3d normalOf(const PoseHypothesis& pose) {
  return planar_bin_picking::normalOf(pose.T_camera_part, pose.face);
}

/// A scene with an aligner over it, for one part.
class Viewed {
 public:
  Viewed(const sim::Plate& plate, const sim::Scene& scene)
      : shot_(shoot(scene)),
        parts_{makePart("plate", plate)},
        aligner_(shot_.edges, shot_.camera, params_, parts_) {}
  Viewed(const sim::Plate& plate, const Eigen::Isometry3d& T_camera_part)
      : Viewed(plate, sceneAt(plate, T_camera_part)) {}
  Viewed(const Viewed&) = delete;
  Viewed& operator=(const Viewed&) = delete;

  static sim::Scene sceneAt(const sim::Plate& plate, const Eigen::Isometry3d& T_camera_part) {
    sim::Scene scene;
    scene.plates.push_back({plate, T_camera_part});
    return scene;
  }
  PoseHypothesis alignedAt(const Eigen::Isometry3d& T_camera_part) const {
    PoseHypothesis pose;
    pose.face = faceOf(T_camera_part);
    pose.T_camera_part = T_camera_part;
    aligner_.alignNarrow(&pose);
    return pose;
  }
  ChosenPose chosenFrom(const Eigen::Isometry3d& T_camera_part) const {
    return chooseHypothesis(aligner_, params_, alignedAt(T_camera_part));
  }
  RefineParams& params() { return params_; }
  const Aligner& aligner() const { return aligner_; }
  const Parts& parts() const { return parts_; }

 private:
  RefineParams params_;
  Shot shot_;
  Parts parts_;
  Aligner aligner_;
};

}  // namespace planar_bin_picking
