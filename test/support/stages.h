// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Drawn scenes taken through the stages, for the tests of the later ones.

#include "image/edges.h"
#include "locate/judge/score.h"
#include "locate/refine/refine.h"
#include "support/plates.h"

namespace planar_bin_picking {

using Parts = std::vector<std::shared_ptr<const PartModel>>;

inline const sim::PinholeCamera kPinhole;

/// A picture and what the stages after the first need of it.
struct Shot {
  cv::Mat image;
  Camera camera;
  EdgeMap edges;
};

inline Shot shoot(const sim::Scene& scene) {
  const cv::Mat image = sim::takeImage(kPinhole, scene);
  const Camera camera = makeCamera(kPinhole);
  return {image, camera, findEdges(image, camera, {}, 1)};
}

/// T_camera_part, `off_mm` to the right and turned by `turn_deg` in its plane and `tilt_deg` out of
/// it.
inline Candidate candidateNear(const Eigen::Isometry3d& T_camera_part, double off_mm = 0.0,
                               double turn_deg = 0.0, double tilt_deg = 0.0) {
  Candidate out;
  out.face = faceOf(T_camera_part);
  out.T_camera_part = Eigen::Translation3d(1e-3 * off_mm, 0.0, 0.0) * T_camera_part *
                      Eigen::AngleAxisd(turn_deg * kDegrees, Eigen::Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(tilt_deg * kDegrees, Eigen::Vector3d::UnitX());
  return out;
}

inline RefinedPose refinedAt(const Eigen::Isometry3d& T_camera_part, std::size_t part = 0) {
  RefinedPose out;
  out.part = part;
  out.face = faceOf(T_camera_part);
  out.T_camera_part = T_camera_part;
  return out;
}

}  // namespace planar_bin_picking
