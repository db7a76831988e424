// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/tilt_curve.h"

#include "image/edge_search.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = EIGEN_PI / 180.0;

/// Tilts of the curve, from the line of sight; an odd number of them.
constexpr double kStep = 2.0 * kRadians;
constexpr int kStepsToSide = 20;
/// How the edges are sought and weighed: as in the last alignment (aligner.cpp).
constexpr SearchProfile kProfile{4, true, 0.8};
constexpr double kTukeyPx = 2.0;
constexpr int kIterations = 3;  // of the weights at one tilt, from those at the one before
/// What is known without any edge, as so many edges with an error of a pixel; and what is given.
constexpr double kPrior = 1.0, kHeld = 1e9;
/// Edges of one side, an eighth of the outline, err together by so many pixels
/// (image_alignment.cpp); each edge for itself by as many at least.
constexpr double kBiasPx = 0.15, kLeastPx = 0.1;
constexpr int kSides = 8;

using Matrix7d = Eigen::Matrix<double, 7, 7>;

}  // namespace

double TiltCurve::tiltOf(std::size_t point) {
  return (static_cast<double>(point) - kStepsToSide) * kStep;
}

void TiltCurve::findRows(const EdgeMap& edges, const Camera& camera,
                         const std::vector<LocalPoint>& points, const Solid& solid) {
  const auto seen = posePoints(camera, points, solid.radius, T_);
  std::vector<EdgeHit> hits;
  findEach(edges, kProfile, seen, &hits);
  for (std::size_t i = 0; i < points.size(); ++i) {
    PosedPoint at;
    if (!pointAt(seen, i, &at) || !hits[i].found) continue;
    const LocalPoint& p = points[i];
    Vector7d J;
    J << normalJacobian(p, at), -at.out_px;
    const double trust = trustOf(wallWidth(solid, at.deep_px), kProfile.reach_px);
    rows_.push_back({J, {p.x, p.y, 0.0}, hits[i].offset_px, trust});
  }
}

/// Iterated by Tukey's weights. A turn is not linear, so what it does to a point is taken as the
/// point's displacement.
TiltCurve::Fit TiltCurve::fitAt(double turn, Fit fit, double offset, double offset_held) const {
  const Eigen::Matrix3d displace =
      Eigen::AngleAxisd(turn, axis_).toRotationMatrix() - Eigen::Matrix3d::Identity();
  for (int k = 0; k < kIterations; ++k) {
    Matrix7d H = kPrior * Matrix7d::Identity();
    H.block<3, 3>(3, 3) += kHeld * axis_ * axis_.transpose();
    H(6, 6) += offset_held;
    Vector7d b = Vector7d::Zero();
    b(6) = offset_held * offset;
    fit.squares = 0.0;
    for (const Row& row : rows_) {
      const double start = row.J.head<3>().dot(displace * row.at) - row.offset_px;
      const double r = start + row.J.dot(fit.x);
      const double e = 1.0 - r * r / (kTukeyPx * kTukeyPx);
      fit.squares += row.trust * kTukeyPx * kTukeyPx / 3.0 * (e > 0.0 ? 1.0 - e * e * e : 1.0);
      if (e <= 0.0) continue;
      const Vector7d wJ = row.trust * e * e * row.J;
      H.noalias() += wJ * row.J.transpose();
      b.noalias() -= start * wJ;
    }
    const Eigen::LDLT<Matrix7d> solver(H);
    fit.x = solver.solve(b);
    fit.information = 1.0 / solver.solve(Vector7d(Vector7d::Unit(6)))(6);
  }
  return fit;
}

Eigen::Isometry3d TiltCurve::poseOf(const Fit& fit, double turn) const {
  return stepped(T_, fit.x.head<6>(), radius_) * Eigen::AngleAxisd(turn, axis_);
}

TiltPoint TiltCurve::pointOf(const Fit& fit, double tilt) const {
  return {poseOf(fit, to_sight_ + tilt), 0.5 * fit.squares / variance_,
          offset_ + radius_ * fit.x(6), radius_ * std::sqrt(variance_ / fit.information)};
}

TiltCurve::TiltCurve(const EdgeMap& edges, const Camera& camera, const PoseHypothesis& pose,
                     const PartOutline& outline, const Eigen::Vector2d& length)
    : T_(pose.T_camera_part * centreOf(*outline.part, pose.face)),
      radius_(outline.part->radius()),
      offset_(outline.of(pose.face).offset),
      axis_(length.x(), length.y(), 0.0) {
  findRows(edges, camera, outline.of(pose.face).fine, solidOf(*outline.part, pose.face));
  variance_ = kLeastPx * kLeastPx + pose.image.residual_px * pose.image.residual_px +
              kBiasPx * kBiasPx * static_cast<double>(rows_.size()) / kSides;
  const double up = pose.face == Face::kFront ? 1.0 : -1.0;
  const Eigen::Vector3d sight = -up * (T_.linear().transpose() * T_.translation());
  to_sight_ = std::atan2(sight.dot(axis_.cross(Eigen::Vector3d::UnitZ())), sight.z());
  // From the tilt where the edges were found to either side, each from the one before.
  const int last = 2 * kStepsToSide;
  const int first =
      std::clamp(static_cast<int>(std::lround(-to_sight_ / kStep)) + kStepsToSide, 0, last);
  fits_.resize(last + 1);
  points_.resize(last + 1);
  for (const int way : {1, -1}) {
    Fit fit;
    for (int k = first; k >= 0 && k <= last; k += way) {
      fit = fits_[k] = fitAt(to_sight_ + tiltOf(k), fit, 0.0, 0.0);
      points_[k] = pointOf(fit, tiltOf(k));
    }
  }
}

std::size_t TiltCurve::nearest(double tilt) const {
  return std::clamp(static_cast<int>(std::lround(tilt / kStep)) + kStepsToSide, 0,
                    2 * kStepsToSide);
}

Eigen::Isometry3d TiltCurve::poseAt(double tilt, double offset) const {
  const double turn = to_sight_ + tilt;
  return poseOf(fitAt(turn, fits_[nearest(tilt)], (offset - offset_) / radius_, kHeld), turn);
}

}  // namespace planar_bin_picking
