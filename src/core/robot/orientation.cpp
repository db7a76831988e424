// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/robot/orientation.h"

#include "planar_bin_picking/base/se3.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kMillimetre = 1e-3;
constexpr double kFarthest = 100.0;  // m; further off, millimetres were given for metres

/// Angles (about z, y, x) of R = Rz Ry Rx, radians. Where y is 90 degrees, x is zero.
std::array<double, 3> zyx(const Eigen::Matrix3d& R) {
  constexpr double kUpright = 1e-9;  // cosine of y, below which z and x turn about one line
  const double cosine = std::hypot(R(0, 0), R(1, 0));
  const double y = std::atan2(-R(2, 0), cosine);
  if (cosine < kUpright) return {std::atan2(-R(0, 1), R(1, 1)), y, 0.0};
  return {std::atan2(R(1, 0), R(0, 0)), y, std::atan2(R(2, 1), R(2, 2))};
}

Eigen::Matrix3d about(const double degrees, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(degrees * kDegree, axis).toRotationMatrix();
}

Eigen::Matrix3d fromZyx(const double z, const double y, const double x) {
  return about(z, Eigen::Vector3d::UnitZ()) * about(y, Eigen::Vector3d::UnitY()) *
         about(x, Eigen::Vector3d::UnitX());
}

std::vector<double> orientationOf(const Eigen::Matrix3d& R, const PoseConvention convention) {
  const auto [z, y, x] = zyx(R);
  switch (convention) {
    case PoseConvention::kKuka:
      return {z / kDegree, y / kDegree, x / kDegree};
    case PoseConvention::kFanuc:
    case PoseConvention::kPlain:
      return {x / kDegree, y / kDegree, z / kDegree};
    case PoseConvention::kUr: {
      const Eigen::Vector3d vector = rotationVector(R);
      return {vector.x(), vector.y(), vector.z()};
    }
    case PoseConvention::kAbb: {
      const Eigen::Quaterniond q = quaternionOf(R);
      return {q.w(), q.x(), q.y(), q.z()};
    }
    case PoseConvention::kStaubli:
      break;
  }
  // R = Rx Ry Rz is the transpose of Rz(-c) Ry(-b) Rx(-a).
  const auto [c, b, a] = zyx(R.transpose());
  return {-a / kDegree, -b / kDegree, -c / kDegree};
}

Eigen::Matrix3d rotationOf(const std::vector<double>& n, const PoseConvention convention) {
  switch (convention) {
    case PoseConvention::kKuka:
      return fromZyx(n[3], n[4], n[5]);
    case PoseConvention::kFanuc:
    case PoseConvention::kPlain:
      return fromZyx(n[5], n[4], n[3]);
    case PoseConvention::kUr: {
      const Eigen::Vector3d vector(n[3], n[4], n[5]);
      const double angle = vector.norm();
      if (angle == 0.0) return Eigen::Matrix3d::Identity();
      return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
    }
    case PoseConvention::kAbb: {
      constexpr double kTolerance = 0.01;
      const Eigen::Quaterniond q(n[3], n[4], n[5], n[6]);
      if (std::abs(q.norm() - 1.0) > kTolerance)
        throw std::invalid_argument("the quaternion has length " + std::to_string(q.norm()) +
                                    "; it must be 1: check the order of the numbers");
      return q.normalized().toRotationMatrix();
    }
    case PoseConvention::kStaubli:
      break;
  }
  return fromZyx(-n[5], -n[4], -n[3]).transpose();
}

double unitOf(const PoseConvention convention) {
  return convention == PoseConvention::kUr ? 1.0 : kMillimetre;
}

}  // namespace

std::optional<PoseConvention> poseConvention(const std::string& name) {
  static const std::array<std::pair<const char*, PoseConvention>, 6> kNames{{
      {"kuka", PoseConvention::kKuka},
      {"fanuc", PoseConvention::kFanuc},
      {"ur", PoseConvention::kUr},
      {"abb", PoseConvention::kAbb},
      {"staubli", PoseConvention::kStaubli},
      {"plain", PoseConvention::kPlain},
  }};
  for (const auto& [word, convention] : kNames)
    if (name == word) return convention;
  return std::nullopt;
}

std::size_t poseNumbers(const PoseConvention convention) {
  return convention == PoseConvention::kAbb ? 7 : 6;
}

std::vector<double> toNumbers(const Eigen::Isometry3d& T_base_pose,
                              const PoseConvention convention) {
  const Eigen::Vector3d position = T_base_pose.translation() / unitOf(convention);
  std::vector<double> numbers{position.x(), position.y(), position.z()};
  const auto orientation = orientationOf(T_base_pose.linear(), convention);
  numbers.insert(numbers.end(), orientation.begin(), orientation.end());
  return numbers;
}

Eigen::Isometry3d fromNumbers(const std::vector<double>& numbers, const PoseConvention convention) {
  if (numbers.size() != poseNumbers(convention)) {
    throw std::invalid_argument("a pose has " + std::to_string(poseNumbers(convention)) +
                                " numbers, here are " + std::to_string(numbers.size()));
  }
  if (!std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); }))
    throw std::invalid_argument("a pose must have finite numbers");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = unitOf(convention) * Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  if (T.translation().norm() > kFarthest)
    throw std::invalid_argument("the pose is " + std::to_string(T.translation().norm()) +
                                " m away; check millimetres and metres");
  T.linear() = rotationOf(numbers, convention);
  return T;
}

}  // namespace planar_bin_picking
