// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/prior/plane_prior.h"

#include "planar_bin_picking/base/se3.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_bin_picking {
namespace {

using Matrix36d = Eigen::Matrix<double, 3, 6>;

double tiltSigma(const PlaneParams& params) { return params.sigma_tilt_deg * EIGEN_PI / 180.0; }

/// How far a face is off the plane: its height, and the plane's normal along its x and y.
struct Residual {
  Eigen::Vector3d value;
  Matrix36d jacobian;  ///< by xi in T_camera_face * exp(xi)
};

Residual residualOf(const Eigen::Isometry3d& T_camera_face, double thickness, const Plane& plane) {
  const Eigen::Vector3d normal_face = T_camera_face.linear().transpose() * plane.normal_camera;
  const double height = plane.normal_camera.dot(T_camera_face.translation()) + plane.distance;
  Residual r;
  r.value << height - thickness, normal_face.head<2>();
  r.jacobian.setZero();
  r.jacobian.topLeftCorner<1, 3>() = normal_face.transpose();
  r.jacobian.bottomRightCorner<2, 3>() = skew(normal_face).topRows<2>();
  return r;
}

}  // namespace

std::optional<Plane> planeOf(const PlaneParams& params) {
  if (params.distance == 0.0) return std::nullopt;
  return Plane{Eigen::Vector3d(params.normal_x, params.normal_y, params.normal_z).normalized(),
               params.distance};
}

std::optional<Distances> distancesOnPlane(const Camera& camera, const Plane& plane,
                                          double thickness, const Distances& within,
                                          const PlaneParams& params) {
  constexpr double kGrazing = 1e-3;  // beyond, the plane reaches the horizon
  const double slack = params.gate * (params.sigma + tiltSigma(params) * plane.distance);
  const double right = camera.model().width - 1.0, bottom = camera.model().height - 1.0;
  Distances seen{std::numeric_limits<double>::infinity(), 0.0};
  for (const double x : {0.0, right}) {
    for (const double y : {0.0, bottom}) {
      const Eigen::Vector3d ray = camera.undistort({x, y}).homogeneous();
      const double fall = -plane.normal_camera.dot(ray);  // toward the plane, per metre of depth
      if (fall < kGrazing) return within;
      seen.min = std::min(seen.min, (plane.distance - thickness - slack) / fall);
      seen.max = std::max(seen.max, (plane.distance - thickness + slack) / fall);
    }
  }
  const Distances both{std::max(seen.min, within.min), std::min(seen.max, within.max)};
  if (both.min > both.max) return std::nullopt;
  return both;
}

std::optional<RefinedPose> fuseWithPlane(const RefinedPose& pose, const PartModel& part,
                                         const Plane& plane, const PlaneParams& params) {
  constexpr int kRounds = 3;
  const Eigen::Isometry3d T_part_face(
      Eigen::Translation3d(part.center().x(), part.center().y(), part.faceZ(pose.face)));
  const Eigen::Isometry3d T_camera_face = pose.T_camera_part * T_part_face;
  const Eigen::Vector3d sigmas(params.sigma, tiltSigma(params), tiltSigma(params));
  const Eigen::Matrix3d noise = sigmas.cwiseAbs2().asDiagonal();

  Vector6d xi = Vector6d::Zero();
  Matrix6d covariance = pose.covariance;
  for (int round = 0; round < kRounds; ++round) {
    const Residual r = residualOf(T_camera_face * exp(xi), part.thickness(), plane);
    const Eigen::Matrix3d spread = r.jacobian * pose.covariance * r.jacobian.transpose() + noise;
    const Eigen::LDLT<Eigen::Matrix3d> solver(spread);
    if (round == 0 && r.value.dot(solver.solve(r.value)) > params.gate * params.gate)
      return std::nullopt;
    const Eigen::Matrix<double, 6, 3> gain = solver.solve(r.jacobian * pose.covariance).transpose();
    xi = gain * (r.jacobian * xi - r.value);
    covariance = pose.covariance - gain * r.jacobian * pose.covariance;
  }
  RefinedPose fused = pose;
  fused.T_camera_part = T_camera_face * exp(xi) * T_part_face.inverse();
  fused.covariance = 0.5 * (covariance + covariance.transpose());
  return fused;
}

std::vector<RefinedPose> fuseWithPlane(const std::vector<RefinedPose>& poses,
                                       const std::vector<std::shared_ptr<const PartModel>>& parts,
                                       const Plane& plane, const PlaneParams& params) {
  std::vector<RefinedPose> fused;
  for (const RefinedPose& pose : poses)
    if (const auto on_plane = fuseWithPlane(pose, *parts.at(pose.part), plane, params))
      fused.push_back(*on_plane);
  return fused;
}

}  // namespace planar_bin_picking
