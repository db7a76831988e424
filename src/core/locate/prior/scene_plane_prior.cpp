// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/scene_plane_prior.h"

#include "base/scatter.h"
#include "part/outline_view.h"
#include "planar_bin_picking/base/se3.h"

#include <Eigen/Cholesky>

#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = EIGEN_PI / 180.0;

/// A pose's visible face: its centre frame, and a normal along that frame's axes.
struct Lying {
  Eigen::Isometry3d T_camera_centre;
  double up;  // the frame's z axis times this points toward the camera

  Lying(const RefinedPose& pose, const PartModel& part)
      : T_camera_centre(pose.T_camera_part * centreOf(part, pose.face)),
        up(pose.face == Face::kFront ? 1.0 : -1.0) {}
  Eigen::Vector3d normal() const { return up * T_camera_centre.linear().col(2); }
  Eigen::Vector3d inCentre(const Eigen::Vector3d& normal_camera) const {
    return T_camera_centre.linear().transpose() * normal_camera;
  }
};

double underside(const Lying& lying, const PartModel& part, const Eigen::Vector3d& normal_camera) {
  return normal_camera.dot(lying.T_camera_centre.translation()) - part.thickness();
}

/// Of the two tilts, per axis.
double tiltVariance(const RefinedPose& pose) {
  return 0.5 * (pose.covariance(3, 3) + pose.covariance(4, 4));
}

double heightVariance(const RefinedPose& pose, const Eigen::Vector3d& normal_centre) {
  return normal_centre.dot(pose.covariance.topLeftCorner<3, 3>() * normal_centre);
}

/// Variance among the others that are like this one, by how far it is off: a few lie anyhow.
double varianceAt(double off2, int dimensions, double measured, double spread, double anyhow) {
  constexpr double kShareAnyhow = 0.1;
  const auto density = [&](double sigma) {
    const double variance = measured + sigma * sigma;
    return std::exp(-0.5 * off2 / variance) / std::pow(variance, 0.5 * dimensions);
  };
  const bool alike = (1.0 - kShareAnyhow) * density(spread) > kShareAnyhow * density(anyhow);
  return alike ? spread * spread : anyhow * anyhow;
}

}  // namespace

std::optional<CommonLie> commonLie(const std::vector<RefinedPose>& poses,
                                   const std::vector<std::shared_ptr<const PartModel>>& parts) {
  constexpr std::size_t kFew = 6;
  constexpr double kLeastTilt = 0.2 * kRadians, kLeastHeight = 0.2e-3;
  if (poses.size() < kFew) return std::nullopt;
  std::vector<Lying> lying;
  for (const auto& p : poses) lying.emplace_back(p, *parts[p.part]);
  CommonLie lie;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> normals, places;
    for (const auto& l : lying) {
      normals.push_back(l.normal()(axis));
      places.push_back(l.T_camera_centre.translation()(axis));
    }
    lie.normal_camera(axis) = median(normals);
    lie.middle_camera(axis) = median(places);
  }
  lie.normal_camera.normalize();
  std::vector<double> heights;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    heights.push_back(underside(lying[i], *parts[poses[i].part], lie.normal_camera));
  }
  lie.height = median(heights);
  std::vector<double> tilts, tilt_variances, rises, height_variances;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    tilts.push_back((lying[i].normal() - lie.normal_camera).squaredNorm());
    tilt_variances.push_back(tiltVariance(poses[i]));
    rises.push_back(std::pow(heights[i] - lie.height, 2));
    height_variances.push_back(heightVariance(poses[i], lying[i].inCentre(lie.normal_camera)));
  }
  lie.tilt_spread = std::sqrt(scatterBeyond(tilts, kVarianceOfTwo, tilt_variances, kLeastTilt));
  lie.height_spread =
      std::sqrt(scatterBeyond(rises, kVarianceOfOne, height_variances, kLeastHeight));
  // Light, bevel and focal length move the edges of all parts alike, so the errors of tilts average
  // out but those of heights do only in part.
  constexpr double kAlike = 0.5;
  const double count = static_cast<double>(poses.size());
  lie.tilt_sigma = std::sqrt((std::pow(lie.tilt_spread, 2) + median(tilt_variances)) / count);
  lie.height_sigma = kAlike * std::sqrt(median(height_variances));
  return lie;
}

void fuseWithCommonLie(const CommonLie& lie,
                       const std::vector<std::shared_ptr<const PartModel>>& parts,
                       std::vector<RefinedPose>* poses) {
  constexpr double kAnyTilt = 15.0 * kRadians, kAnyHeight = 0.05;
  for (auto& p : *poses) {
    const PartModel& part = *parts[p.part];
    const Lying lying(p, part);
    const Eigen::Vector3d n = lying.inCentre(lie.normal_camera);
    // Zero where the part lies like the others: underside, normal along the part's x and y.
    Eigen::Vector3d off;
    off << underside(lying, part, lie.normal_camera) - lie.height, lying.up * n.head<2>();
    Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
    J.topLeftCorner<1, 3>() = n.transpose();
    J.bottomRightCorner<2, 3>() = lying.up * skew(n).topRows<2>();  // a turn w takes n to n - w x n
    const Eigen::Matrix3d measured = J * p.covariance * J.transpose();
    const double aside = (lying.T_camera_centre.translation() - lie.middle_camera).norm();
    const double plane2 = std::pow(lie.height_sigma, 2) + std::pow(lie.tilt_sigma * aside, 2);
    const double height2 = plane2 + varianceAt(off(0) * off(0), 1, measured(0, 0) + plane2,
                                               lie.height_spread, kAnyHeight);
    const double tilt2 =
        varianceAt(off.tail<2>().squaredNorm(), 2, 0.5 * measured.bottomRightCorner<2, 2>().trace(),
                   lie.tilt_spread, kAnyTilt);
    const Eigen::Matrix3d sum =
        measured + Eigen::Matrix3d(Eigen::Vector3d(height2, tilt2, tilt2).asDiagonal());
    const Eigen::Matrix<double, 6, 3> gain = sum.ldlt().solve(J * p.covariance).transpose();
    const Vector6d xi = -gain * off;
    p.T_camera_part = lying.T_camera_centre * exp(xi) * centreOf(part, p.face).inverse();
    const Matrix6d left = p.covariance - gain * J * p.covariance;
    p.covariance = 0.5 * (left + left.transpose());
  }
}

}  // namespace planar_bin_picking
