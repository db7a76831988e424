// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/prior/plane_prior.h"

#include "locate/prior/flat_face.h"
#include "part/outline_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_bin_picking {
namespace {

constexpr double kGrazing = 1e-3;  // metres of fall per metre of depth: less is the horizon

double tiltSigma(const PlaneParams& params) { return params.sigma_tilt_deg * EIGEN_PI / 180.0; }

}  // namespace

std::optional<Plane> planeOf(const PlaneParams& params) {
  if (params.distance == 0.0) return std::nullopt;
  return Plane{Eigen::Vector3d(params.normal_x, params.normal_y, params.normal_z).normalized(),
               params.distance};
}

std::optional<Distances> distancesOnPlane(const Camera& camera, const Plane& plane,
                                          double thickness, const Distances& within,
                                          const PlaneParams& params) {
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
  const double tilt_variance = std::pow(tiltSigma(params), 2);
  const Eigen::Vector3d variances(params.sigma * params.sigma, tilt_variance, tilt_variance);
  const auto prior =
      flatOn(plane, pose.T_camera_part * centreOf(part, pose.face), part.thickness(), variances);
  const Eigen::Matrix3d spread =
      prior.jacobian * pose.covariance * prior.jacobian.transpose() + prior.covariance;
  if (prior.residual.dot(spread.ldlt().solve(prior.residual)) > params.gate * params.gate)
    return std::nullopt;
  RefinedPose out = fuseFlat(pose, part, plane, variances);
  out.other_tilt.setZero();  // the plane tells the two apart
  return out;
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
