// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/common_normal.h"

#include "base/scatter.h"
#include "planar_bin_picking/base/se3.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = EIGEN_PI / 180.0;

/// By how much parts that lie alike differ: as so many parts would tell before anything is seen,
/// and at most; how the others lie about these; how parts lie about the line of sight where nothing
/// is known of them. Per axis.
constexpr double kAlike = 1.5 * kRadians, kAlikeParts = 2.0, kAlikeMost = 4.0 * kRadians;
constexpr double kOutlying = 15.0 * kRadians, kAny = 30.0 * kRadians;
/// Standard deviation of a slender part's tilt about its length beyond what the image states.
constexpr double kUnknown = 15.0 * kRadians;
/// So many parts of a picture lie as no other, as before anything is seen; so many determine a
/// normal.
constexpr double kOutlyingParts = 1.0, kDetermine = 1.0;
constexpr int kRounds = 8;  // of who shares the normal and what it is
/// A share of the parts that lie alike to begin with.
constexpr double kShare = 0.5;

double density(double off2, double variance) {
  return std::exp(-0.5 * off2 / variance) / std::sqrt(variance);
}

/// Two unit vectors across a normal, as columns.
Eigen::Matrix<double, 3, 2> tangents(const Eigen::Vector3d& normal) {
  Eigen::Matrix<double, 3, 2> out;
  out.col(0) = normal.unitOrthogonal();
  out.col(1) = normal.cross(out.col(0));
  return out;
}

/// Density of a normal so far off.
double density(const Eigen::Vector2d& off, const Eigen::Matrix2d& covariance) {
  return std::exp(-0.5 * off.dot(covariance.ldlt().solve(off))) /
         std::sqrt(covariance.determinant());
}

}  // namespace

MeasuredNormal measuredNormal(const Eigen::Isometry3d& T_camera_part, Face face,
                              const Eigen::Matrix3d& rotation,
                              const std::optional<Eigen::Vector2d>& length) {
  Eigen::Matrix3d turns = rotation;
  if (length) {
    const Eigen::Vector3d axis(length->x(), length->y(), 0.0);
    turns += kUnknown * kUnknown * axis * axis.transpose();
  }
  const Eigen::Matrix3d R = T_camera_part.linear();
  MeasuredNormal out;
  out.normal_camera = (face == Face::kFront ? 1.0 : -1.0) * R.col(2);
  const Eigen::Matrix3d to_normal = -skew<double>(out.normal_camera) * R;
  out.covariance = to_normal * turns * to_normal.transpose();
  return out;
}

CommonNormal commonNormal(const std::vector<MeasuredNormal>& normals, std::size_t left_out) {
  CommonNormal out;
  std::array<std::vector<double>, 3> values;
  for (std::size_t j = 0; j < normals.size(); ++j)
    for (int axis = 0; axis < 3 && j != left_out; ++axis)
      values[axis].push_back(normals[j].normal_camera(axis));
  if (values[0].empty()) return out;
  for (int axis = 0; axis < 3; ++axis) out.normal(axis) = median(values[axis]);
  out.normal.normalize();
  out.spread = kAlike;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Matrix<double, 3, 2> across = tangents(out.normal);
    Eigen::Matrix2d information =
        Eigen::Matrix2d::Identity() / (kOutlying * kOutlying);  // about where it is now
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double parts = 0.0, squares = kAlikeParts * kAlike * kAlike;
    for (std::size_t j = 0; j < normals.size(); ++j) {
      if (j == left_out) continue;
      const Eigen::Vector2d off = across.transpose() * (normals[j].normal_camera - out.normal);
      const Eigen::Matrix2d measured = across.transpose() * normals[j].covariance * across;
      const Eigen::Matrix2d alike =
          measured + out.spread * out.spread * Eigen::Matrix2d::Identity();
      const double inside = kShare * density(off, alike);
      const double outside =
          (1.0 - kShare) *
          density(off, measured + kOutlying * kOutlying * Eigen::Matrix2d::Identity());
      const double shares = inside / (inside + outside);
      const Eigen::Matrix2d weight = shares * alike.inverse();
      information += weight;
      sum += weight * off;
      parts += shares;
      // The direction that the part tells best: a slender one, its length.
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(measured);
      squares += shares * std::max(0.0, std::pow(axes.eigenvectors().col(0).dot(off), 2) -
                                            axes.eigenvalues()(0));
    }
    out.spread = std::min(kAlikeMost, std::sqrt(squares / (kAlikeParts + parts)));
    const Eigen::Matrix2d covariance = information.inverse();
    out.normal = (out.normal + across * covariance * sum).normalized();
    out.covariance = across * covariance * across.transpose();
    out.parts = std::max(0.0, parts - kDetermine);
  }
  return out;
}

double logTiltPrior(const CommonNormal& common, const Eigen::Vector3d& normal_camera,
                    const Eigen::Vector3d& across, double sight_tilt) {
  const double any = density(sight_tilt * sight_tilt, kAny * kAny);
  const double off = across.dot(normal_camera - common.normal);
  const double known = across.dot(common.covariance * across);
  const double inside = density(off * off, known + common.spread * common.spread);
  const double outside = density(off * off, known + kOutlying * kOutlying);
  const double parts = common.parts + kOutlyingParts;
  return std::log((common.parts * inside + 0.5 * kOutlyingParts * (outside + any)) / parts);
}

}  // namespace planar_bin_picking
