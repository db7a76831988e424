// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/figure.h"

#include "base/polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace planar_bin_picking {
namespace {

constexpr double kSamples = 4000.0;     // along all loops, beside their corners
constexpr double kAcross = 400.0;       // cells along the longer side, so that few lines share one
constexpr double kSpacingLeast = 1e-9;  // mm, against a division by zero
constexpr std::size_t kCornersLeast = 8;  // a polygon of fewer is no circle
/// Of the tolerance: chords lie off a curve by up to 0.01 mm (DrawingParams), a fifth of the usual
/// tolerance.
constexpr double kRound = 0.25;

}  // namespace

Figure::Figure(const std::vector<const Loop*>& loops, const Eigen::Vector2d& center,
               double tolerance)
    : tolerance_(tolerance), circles_(4.0 * tolerance) {
  double length = 0.0;
  Eigen::AlignedBox2d box;
  for (const Loop* loop : loops) {
    Piece piece;
    piece.first_side = sides_.size();
    for (std::size_t i = loop->closed ? 0 : 1; i < loop->points.size(); ++i) {
      const std::size_t before = (i + loop->points.size() - 1) % loop->points.size();
      sides_.emplace_back(loop->points[before] - center, loop->points[i] - center);
      length += (sides_.back().second - sides_.back().first).norm();
      box.extend(sides_.back().first).extend(sides_.back().second);
    }
    piece.last_side = sides_.size();
    addIfRound(&piece, loop->closed);
    pieces_.push_back(piece);
  }
  if (empty()) return;
  for (Piece& piece : pieces_) addSamples(&piece, std::max(length / kSamples, kSpacingLeast));
  addLines(std::max(box.sizes().maxCoeff() / kAcross, 2.0 * tolerance));
}

void Figure::addLines(double cell) {
  lines_ = PlaneIndex<Side>(cell);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(tolerance_);
  for (const auto& [a, b] : sides_) {
    // In parts no longer than a cell, so that each lies in few cells.
    const int parts = std::max(1, static_cast<int>(std::ceil((b - a).norm() / cell)));
    for (int i = 0; i < parts; ++i) {
      const Eigen::Vector2d p = a + (b - a) * (static_cast<double>(i) / parts);
      const Eigen::Vector2d q = a + (b - a) * (static_cast<double>(i + 1) / parts);
      lines_.add(p.cwiseMin(q) - margin, p.cwiseMax(q) + margin, {p, q});
    }
  }
}

void Figure::addSamples(Piece* piece, double spacing) {
  piece->first_sample = samples_.size();
  piece->nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = piece->first_side; k < piece->last_side; ++k) {
    const auto& [a, b] = sides_[k];
    const int parts = std::max(1, static_cast<int>(std::ceil((b - a).norm() / spacing)));
    for (int i = 0; i < parts; ++i)
      samples_.push_back(a + (b - a) * (static_cast<double>(i) / parts));
    samples_.push_back(b);
    piece->nearest = std::min(piece->nearest, distanceToSegment(Eigen::Vector2d::Zero(), a, b));
    piece->farthest = std::max({piece->farthest, a.norm(), b.norm()});
  }
  piece->last_sample = samples_.size();
  // Out of order: what breaks a symmetry is often small, such as one flat of a disk, and is come
  // upon soon.
  std::shuffle(samples_.begin() + piece->first_sample, samples_.end(), std::minstd_rand(1));
  largest_radius_ = std::max(largest_radius_, piece->farthest);
}

/// Most holes are circles: a plate of a thousand is compared by their centres, not by their chords.
void Figure::addIfRound(Piece* piece, bool closed) {
  const std::size_t count = piece->last_side - piece->first_side;
  if (!closed || count < kCornersLeast) return;
  Polygon polygon;
  for (std::size_t k = piece->first_side; k < piece->last_side; ++k)
    polygon.push_back(sides_[k].first);
  const Eigen::Vector2d middle = signedMoment(polygon) / signedArea(polygon);
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (std::size_t k = piece->first_side; k < piece->last_side; ++k) {
    const auto& [a, b] = sides_[k];
    least = std::min(least, distanceToSegment(middle, a, b));
    most = std::max(most, (a - middle).norm());
  }
  // Written so that what is not a number returns, too: the middle of a loop without area.
  if (!(most - least <= kRound * tolerance_)) return;
  piece->round = true;
  piece->circle = {middle, 0.5 * (least + most)};
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(tolerance_);
  circles_.add(middle - margin, middle + margin, piece->circle);
}

bool Figure::holds(const Eigen::Vector2d& point) const {
  const std::vector<Side>& near = lines_.at(point);
  return std::any_of(near.begin(), near.end(), [&](const Side& side) {
    return distanceToSegment(point, side.first, side.second) <= tolerance_;
  });
}

bool Figure::holds(const Circle& circle) const {
  const std::vector<Circle>& near = circles_.at(circle.center);
  return std::any_of(near.begin(), near.end(), [&](const Circle& other) {
    return (circle.center - other.center).norm() + std::abs(circle.radius - other.radius) <=
           tolerance_;
  });
}

bool Figure::mapsToItself(const Eigen::Matrix2d& linear) const {
  return std::all_of(pieces_.begin(), pieces_.end(), [&](const Piece& piece) {
    if (piece.round && holds(Circle{linear * piece.circle.center, piece.circle.radius}))
      return true;
    // It may still lie on what is drawn otherwise, such as two half circles with a step.
    return std::all_of(samples_.begin() + piece.first_sample, samples_.begin() + piece.last_sample,
                       [&](const Eigen::Vector2d& p) { return holds(linear * p); });
  });
}

std::vector<double> Figure::crossedRadii(int per_loop) const {
  std::vector<double> radii;
  for (const Piece& piece : pieces_) {
    for (int i = 1; i <= per_loop; ++i) {
      const double share = static_cast<double>(i) / (per_loop + 1);
      radii.push_back(piece.nearest + share * (piece.farthest - piece.nearest));
    }
  }
  return radii;
}

double Figure::crossings(double radius, std::vector<double>* angles) const {
  double least = 1.0;
  for (const Piece& piece : pieces_) {
    if (radius < piece.nearest || radius > piece.farthest) continue;
    for (std::size_t k = piece.first_side; k < piece.last_side; ++k) {
      const auto& [a, b] = sides_[k];
      const double length = (b - a).norm();
      if (length == 0.0) continue;
      const Eigen::Vector2d d = (b - a) / length;
      const double foot = -a.dot(d), half2 = radius * radius - (a + foot * d).squaredNorm();
      if (half2 <= 0.0) continue;
      for (const double along : {foot - std::sqrt(half2), foot + std::sqrt(half2)}) {
        if (along < 0.0 || along >= length) continue;
        const Eigen::Vector2d p = a + along * d;
        angles->push_back(std::atan2(p.y(), p.x()));
        least = std::min(least, std::abs(p.dot(d)) / radius);
      }
    }
  }
  return least;
}

}  // namespace planar_bin_picking
