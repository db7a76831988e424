// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/slides.h"

#include "locate/align/field_alignment.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Share of the outline that stays on itself, to within so many radii (two pixels for a radius of
/// 400).
constexpr double kShare = 0.7, kStays = 0.005;
/// Amount of a motion at most, radii: with more, a long outline does not stay on itself either.
constexpr double kFar = 0.4;
/// Radii: what moves by less is brought back by a wide alignment.
constexpr double kAligned = 0.06;
/// Displacement per amount from which on a point tells.
constexpr double kTelling = 0.3;
constexpr std::size_t kFew = 4;  // telling points: fewer agree by chance
constexpr int kMotions = 2;      // searched together at most
/// Field pixels by which the fastest point moves from one pose to the next, and off an edgel.
constexpr double kStepPx = 1.5, kReachPx = 3.0;
constexpr int kApart = 3;  // steps between two peaks
/// Poses that are looked at, at most: of more the steps are longer, for time.
constexpr double kMostPoses = 20000.0;

/// Displacement along the normal per unit of x, y, turn and relative size.
Eigen::Vector4d jacobian(const LocalPoint& p) {
  const double nx = p.ty, ny = -p.tx;
  return {nx, ny, p.x * ny - p.y * nx, p.x * nx + p.y * ny};
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& T_camera_centre, double radius,
                        const Eigen::Vector4d& by) {
  Eigen::Isometry3d out =
      T_camera_centre *
      Eigen::Isometry3d(Eigen::Translation3d(radius * by.x(), radius * by.y(), 0.0) *
                        Eigen::AngleAxisd(by.z(), Eigen::Vector3d::UnitZ()));
  out.translation() /= 1.0 + by.w();
  return out;
}

/// The two motions that the outline tells least, and of these first the one that moves the bulk of
/// it less: a bar along its length, not that mixed with a change of size. In columns.
Eigen::Matrix<double, 4, kMotions> weakest(const std::vector<LocalPoint>& shape) {
  Eigen::Matrix4d all = Eigen::Matrix4d::Zero();
  for (const auto& p : shape) all += jacobian(p) * jacobian(p).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(all);
  const Eigen::Matrix<double, 4, kMotions> plane = solver.eigenvectors().leftCols<kMotions>();
  std::vector<Eigen::Vector2d> moves;
  for (const auto& p : shape) moves.emplace_back(plane.transpose() * jacobian(p));
  std::sort(moves.begin(), moves.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.squaredNorm() < b.squaredNorm();
  });
  Eigen::Matrix2d bulk = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(kShare * moves.size()); ++i)
    bulk += moves[i] * moves[i].transpose();
  return plane * Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(bulk).eigenvectors();
}

}  // namespace

Slides::Slides(const std::vector<LocalPoint>& shape) {
  if (shape.empty()) return;
  const Eigen::Matrix<double, 4, kMotions> directions = weakest(shape);
  for (int k = 0; k < kMotions; ++k) {
    const Eigen::Vector4d direction = directions.col(k);
    std::vector<double> moves;
    for (const auto& p : shape) moves.push_back(std::abs(jacobian(p).dot(direction)));
    std::sort(moves.begin(), moves.end());
    const double mostly =
        moves[static_cast<std::size_t>(kShare * static_cast<double>(moves.size() - 1))];
    const double most = mostly * kFar > kStays ? kStays / mostly : kFar;
    if (most * moves.back() > kAligned) motions_.push_back({direction, most, moves.back()});
  }
  std::vector<LocalPoint> telling;
  for (const auto& p : shape) {
    if (std::any_of(motions_.begin(), motions_.end(), [&](const Motion& m) {
          return std::abs(jacobian(p).dot(m.direction)) > kTelling;
        }))
      telling.push_back(p);
  }
  if (telling.size() < kFew) motions_.clear();
  telling_ = telling;
}

std::vector<SlidPose> Slides::peaks(const Field& field, double radius,
                                    const Eigen::Isometry3d& T_camera_centre,
                                    std::size_t count) const {
  if (empty()) return {};
  struct Place {
    double score;
    std::array<int, kMotions> steps;
  };
  const double radius_px = field.focal * radius / T_camera_centre.translation().z();
  double poses = 1.0;
  for (const Motion& motion : motions_)
    poses *= 2.0 * motion.most * motion.fastest * radius_px / kStepPx + 1.0;
  const double step_px = kStepPx * std::sqrt(std::max(1.0, poses / kMostPoses));
  std::array<int, kMotions> steps{};
  std::array<double, kMotions> step{};
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    step[k] = step_px / (radius_px * motions_[k].fastest);
    steps[k] = static_cast<int>(motions_[k].most / step[k]);
  }
  const auto poseAt = [&](const std::array<int, kMotions>& at) {
    Eigen::Vector4d by = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < motions_.size(); ++k) by += at[k] * step[k] * motions_[k].direction;
    return moved(T_camera_centre, radius, by);
  };
  std::vector<Place> places;
  for (int i = -steps[0]; i <= steps[0]; ++i) {
    for (int j = -steps[1]; j <= steps[1]; ++j) {
      const std::array<int, kMotions> at{i, j};
      places.push_back({fieldInlierScore(field, telling_, radius, poseAt(at), kReachPx), at});
    }
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.score > b.score; });
  std::vector<std::array<int, kMotions>> taken;
  std::vector<SlidPose> out;
  for (const Place& place : places) {
    if (out.size() == count) break;
    const auto near = [&](const std::array<int, kMotions>& other) {
      return std::abs(place.steps[0] - other[0]) < kApart &&
             std::abs(place.steps[1] - other[1]) < kApart;
    };
    if (std::any_of(taken.begin(), taken.end(), near)) continue;
    taken.push_back(place.steps);
    out.push_back({poseAt(place.steps), place.score});
  }
  return out;
}

}  // namespace planar_bin_picking
