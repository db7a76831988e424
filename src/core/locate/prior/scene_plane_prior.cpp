// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/scene_plane_prior.h"

#include "base/scatter.h"
#include "locate/prior/flat_face.h"
#include "part/outline_view.h"
#include "part/part_extent.h"
#include "part/visible_face.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = EIGEN_PI / 180.0;

/// Fewer others do not determine the plane: with four, two may lean on one wall.
constexpr std::size_t kFew = 5;
/// The spreads are taken to be at least this, in rad and metres: sheets are not flatter.
constexpr double kLeastTilt = 0.2 * kRadians, kLeastHeight = 0.2e-3;
/// Standard deviation of the plane's height over that of one part: light, bevel and focal length
/// move the edges of all parts alike, so the errors of tilts average out but those of heights do
/// only in part.
constexpr double kAlike = 0.5;
/// One part in ten is an outlier: it leans on others or on the wall. Standard deviations of such
/// parts, rad and metres: a part of 0.1 m leaning on one of 25 mm, and half a heap's height.
constexpr double kShareOutlying = 0.1, kOutlyingTilt = 15.0 * kRadians, kOutlyingHeight = 0.05;

/// A Gaussian's density but for a power of 2 pi.
double density(double off2, int dimensions, double variance) {
  return std::exp(-0.5 * off2 / variance) / std::pow(variance, 0.5 * dimensions);
}

/// Variance of the prior for a part that is so far off: that of the inliers, or of the outliers.
double varianceAt(double off2, int dimensions, double measured, double spread, double outlying) {
  const bool is_inlier =
      (1.0 - kShareOutlying) * density(off2, dimensions, measured + spread * spread) >
      kShareOutlying * density(off2, dimensions, measured + outlying * outlying);
  return is_inlier ? spread * spread : outlying * outlying;
}

}  // namespace

SceneFaces::SceneFaces(const std::vector<RefinedPose>& poses,
                       const std::vector<std::shared_ptr<const PartModel>>& parts) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const RefinedPose& pose = poses[i];
    const PartModel& part = *parts[pose.part];
    const Eigen::Isometry3d T = pose.T_camera_part * centreOf(part, pose.face);
    const Eigen::Matrix3d& R = T.linear();
    faces_.push_back({normalOf(pose.T_camera_part, pose.face), T.translation(), part.thickness(),
                      0.5 * (pose.covariance(3, 3) + pose.covariance(4, 4)),
                      R * pose.covariance.topLeftCorner<3, 3>() * R.transpose()});
  }
}

std::optional<ScenePlane> SceneFaces::plane(std::optional<std::size_t> left_out) const {
  std::vector<const Face*> faces;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    if (i == left_out) continue;
    faces.push_back(&faces_[i]);
  }
  if (faces.size() < kFew) return std::nullopt;
  std::vector<double> values(faces.size());
  const auto middle = [&](auto&& of) {
    for (std::size_t i = 0; i < faces.size(); ++i) values[i] = of(*faces[i]);
    return median(values);
  };
  ScenePlane out;
  Eigen::Vector3d normal;
  for (int axis = 0; axis < 3; ++axis) {
    normal(axis) = middle([axis](const Face& f) { return f.normal_camera(axis); });
    out.middle_camera(axis) = middle([axis](const Face& f) { return f.centre_camera(axis); });
  }
  normal.normalize();
  const auto underside = [&](const Face& f) { return normal.dot(f.centre_camera) - f.thickness; };
  const double height = middle(underside);
  out.plane = {normal, -height};
  const auto spread = [&](double squares, double to_variance, double measured, double least) {
    return std::sqrt(std::max(least * least, to_variance * squares - measured));
  };
  const double tilt_variance = middle([](const Face& f) { return f.tilt_variance; });
  const double height_variance =
      middle([&](const Face& f) { return normal.dot(f.centre_covariance * normal); });
  out.tilt_spread =
      spread(middle([&](const Face& f) { return (f.normal_camera - normal).squaredNorm(); }),
             kVarianceOfTwo, tilt_variance, kLeastTilt);
  out.height_spread =
      spread(middle([&](const Face& f) { return std::pow(underside(f) - height, 2); }),
             kVarianceOfOne, height_variance, kLeastHeight);
  out.tilt_sigma =
      std::sqrt((std::pow(out.tilt_spread, 2) + tilt_variance) / static_cast<double>(faces.size()));
  out.height_sigma = kAlike * std::sqrt(height_variance);
  return out;
}

void fuseWithScenePlane(const std::vector<std::shared_ptr<const PartModel>>& parts,
                        std::vector<RefinedPose>* poses) {
  const SceneFaces faces(*poses, parts);
  std::vector<bool> slender;
  for (const auto& part : parts) slender.push_back(lengthOfSlender(*part).has_value());
  for (std::size_t i = 0; i < poses->size(); ++i) {
    const auto scene = faces.plane(i);
    if (!scene) continue;
    RefinedPose& pose = (*poses)[i];
    const PartModel& part = *parts[pose.part];
    const Eigen::Isometry3d T_camera_centre = pose.T_camera_part * centreOf(part, pose.face);
    const auto prior = flatOn(scene->plane, T_camera_centre, part.thickness(), {0.0, 0.0, 0.0});
    const Eigen::Matrix3d measured = prior.jacobian * pose.covariance * prior.jacobian.transpose();
    const double aside = (T_camera_centre.translation() - scene->middle_camera).norm();
    const double plane2 = std::pow(scene->height_sigma, 2) + std::pow(scene->tilt_sigma * aside, 2);
    const double height2 =
        plane2 + varianceAt(std::pow(prior.residual(0), 2), 1, measured(0, 0) + plane2,
                            scene->height_spread, kOutlyingHeight);
    // How the others lie is already part of a slender part's tilt (shared_offset.h).
    const double tilt2 = slender[pose.part]
                             ? kOutlyingTilt * kOutlyingTilt
                             : varianceAt(prior.residual.tail<2>().squaredNorm(), 2,
                                          0.5 * measured.bottomRightCorner<2, 2>().trace(),
                                          scene->tilt_spread, kOutlyingTilt);
    pose = fuseFlat(pose, part, scene->plane, {height2, tilt2, tilt2});
  }
}

}  // namespace planar_bin_picking
