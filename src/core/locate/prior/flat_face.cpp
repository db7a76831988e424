// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/flat_face.h"

#include "part/outline_view.h"
#include "planar_bin_picking/base/se3.h"

namespace planar_bin_picking {
namespace {

constexpr int kRounds = 3;  // of the linearization: the third changes a pose by less than 1 um

}  // namespace

LinearPrior<6, 3> flatOn(const Plane& plane, const Eigen::Isometry3d& T_camera_face,
                         double thickness, const Eigen::Vector3d& variances) {
  const Eigen::Vector3d normal_face = T_camera_face.linear().transpose() * plane.normal_camera;
  const double height = plane.normal_camera.dot(T_camera_face.translation()) + plane.distance;
  LinearPrior<6, 3> prior;
  prior.residual << height - thickness, normal_face.head<2>();
  prior.jacobian.setZero();
  prior.jacobian.topLeftCorner<1, 3>() = normal_face.transpose();
  // A turn by w takes the normal, seen from the face, to normal + normal x w.
  prior.jacobian.bottomRightCorner<2, 3>() = skew(normal_face).topRows<2>();
  prior.covariance = variances.asDiagonal();
  return prior;
}

RefinedPose fuseFlat(const RefinedPose& pose, const PartModel& part, const Plane& plane,
                     const Eigen::Vector3d& variances) {
  const Eigen::Isometry3d T_part_face = centreOf(part, pose.face);
  const Eigen::Isometry3d T_camera_face = pose.T_camera_part * T_part_face;
  Estimate<6> image, fused;
  image.covariance = pose.covariance;
  for (int round = 0; round < kRounds; ++round) {
    auto prior = flatOn(plane, T_camera_face * exp(fused.mean), part.thickness(), variances);
    prior.residual -= prior.jacobian * fused.mean;  // it was taken there and is wanted at zero
    fused = fuse(image, prior);
  }
  RefinedPose out = pose;
  out.T_camera_part = T_camera_face * exp(fused.mean) * T_part_face.inverse();
  out.covariance = fused.covariance;
  return out;
}

}  // namespace planar_bin_picking
