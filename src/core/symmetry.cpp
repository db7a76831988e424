// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/symmetry.h"

#include "polygon.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <unordered_map>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMaxOrder = 360;  ///< finer teeth than one degree count as a circle or as none

using Points = std::vector<Eigen::Vector2d>;

/// Answers in constant time whether a point lies on a set of lines, within a tolerance.
class LineIndex {
 public:
  LineIndex(double tolerance, double cell) : tolerance_(tolerance), cell_(cell) {}

  void add(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    // In pieces no longer than a cell, so that each lies in few cells.
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / cell_)));
    for (int i = 0; i < pieces; ++i) {
      const Eigen::Vector2d p = a + (b - a) * (static_cast<double>(i) / pieces);
      const Eigen::Vector2d q = a + (b - a) * (static_cast<double>(i + 1) / pieces);
      const Eigen::Vector2i low = cellOf(p.cwiseMin(q).array() - tolerance_);
      const Eigen::Vector2i high = cellOf(p.cwiseMax(q).array() + tolerance_);
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) cells_[keyOf({x, y})].push_back({p, q});
      }
    }
  }

  bool holds(const Eigen::Vector2d& point) const {
    const auto it = cells_.find(keyOf(cellOf(point)));
    if (it == cells_.end()) return false;
    return std::any_of(it->second.begin(), it->second.end(), [&](const auto& piece) {
      return distanceToSegment(point, piece.first, piece.second) <= tolerance_;
    });
  }

 private:
  Eigen::Vector2i cellOf(const Eigen::Vector2d& p) const {
    return (p / cell_).array().floor().matrix().cast<int>();
  }
  static std::uint64_t keyOf(const Eigen::Vector2i& cell) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell.y())) << 32) |
           static_cast<std::uint32_t>(cell.x());
  }

  double tolerance_, cell_;
  std::unordered_map<std::uint64_t, std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>>
      cells_;
};

/// Loops about a centre: their lines for asking, points on them for mapping.
class Figure {
 public:
  Figure(const std::vector<const Loop*>& loops, const Eigen::Vector2d& center, double tolerance)
      : tolerance_(tolerance), index_(tolerance, 0.0) {
    double length = 0.0;
    forEachSide(loops, center, [&](const auto& a, const auto& b) { length += (b - a).norm(); });
    const double spacing = std::max(length / 4000.0, 1e-9);
    index_ = LineIndex(tolerance, std::max(4.0 * spacing, 2.0 * tolerance));
    forEachSide(loops, center, [&](const auto& a, const auto& b) {
      index_.add(a, b);
      sides_.push_back({a, b});
      const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / spacing)));
      for (int i = 0; i < pieces; ++i)
        samples_.push_back(a + (b - a) * (static_cast<double>(i) / pieces));
      samples_.push_back(b);
    });
  }

  bool empty() const { return sides_.empty(); }
  bool mapsToItself(const Eigen::Matrix2d& linear) const {
    return std::all_of(samples_.begin(), samples_.end(),
                       [&](const Eigen::Vector2d& p) { return index_.holds(linear * p); });
  }
  bool mapsToItselfTurnedBy(double angle) const {
    return mapsToItself(Eigen::Rotation2Dd(angle).toRotationMatrix());
  }

  /// The angles at which the figure crosses a circle about the centre, and how squarely: the least
  /// sine between line and circle.
  double crossings(double radius, std::vector<double>* angles) const {
    double least = 1.0;
    for (const auto& [a, b] : sides_) {
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
    return least;
  }

  double largestRadius() const {
    double largest = 0.0;
    for (const Eigen::Vector2d& p : samples_) largest = std::max(largest, p.norm());
    return largest;
  }

 private:
  template <class Visit>
  static void forEachSide(const std::vector<const Loop*>& loops, const Eigen::Vector2d& center,
                          Visit&& visit) {
    for (const Loop* loop : loops) {
      for (std::size_t i = loop->closed ? 0 : 1; i < loop->points.size(); ++i) {
        const std::size_t before = (i + loop->points.size() - 1) % loop->points.size();
        visit(Eigen::Vector2d(loop->points[before] - center),
              Eigen::Vector2d(loop->points[i] - center));
      }
    }
  }

  double tolerance_;
  LineIndex index_;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> sides_;
  Points samples_;
};

std::vector<const Loop*> loopsOf(const Drawing& drawing, bool print) {
  std::vector<const Loop*> loops;
  for (const Loop& loop : drawing.loops) {
    if ((loop.kind == LoopKind::kPrint) == print) loops.push_back(&loop);
  }
  return loops;
}

/// Holes run clockwise: their area and moment come out negative and are taken off.
Eigen::Vector2d materialCentroid(const std::vector<const Loop*>& outline) {
  double area = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (const Loop* loop : outline) {
    const double sign = loop->kind == LoopKind::kOuter ? 1.0 : -1.0;
    const double loop_area = signedArea(loop->points);
    area += sign * std::abs(loop_area);
    moment += (loop_area < 0.0 ? -sign : sign) * signedMoment(loop->points);
  }
  return moment / area;
}

/// Whether every loop is a circle about the centre: no turn changes the figure.
bool isRound(const std::vector<const Loop*>& loops, const Eigen::Vector2d& center,
             double tolerance) {
  return std::all_of(loops.begin(), loops.end(), [&](const Loop* loop) {
    double least = (loop->points.front() - center).norm(), largest = least;
    for (std::size_t i = 0; i < loop->points.size(); ++i) {
      const Eigen::Vector2d a = loop->points[i] - center;
      const Eigen::Vector2d b = loop->points[(i + 1) % loop->points.size()] - center;
      least = std::min(least, distanceToSegment(Eigen::Vector2d::Zero(), a, b));
      largest = std::max(largest, a.norm());
    }
    return loop->closed && largest - least <= tolerance;
  });
}

/// Whether all turns of that order map the figure to itself. One small turn moves a round figure by
/// less than the tolerance whether or not it is symmetric; the largest turns tell.
bool hasOrder(const Figure& figure, int order) {
  for (int k = order / 2; k > 0; --k) {
    if (!figure.mapsToItselfTurnedBy(2.0 * kPi * k / order)) return false;
  }
  return true;
}

/// The largest order of rotation; `of` = 0 tries all, else its divisors.
int rotationOrder(const Figure& figure, int of) {
  for (int order = of == 0 ? kMaxOrder : of; order > 1; --order) {
    if ((of == 0 || of % order == 0) && hasOrder(figure, order)) return order;
  }
  return 1;
}

/// Axes that could mirror the figure: a mirror maps its crossings with a circle to one another.
std::vector<double> axisCandidates(const Figure& figure) {
  std::vector<double> best;
  double best_quality = 0.0;
  constexpr int kRadii = 200;
  for (int i = 1; i < kRadii; ++i) {
    std::vector<double> angles;
    const double share = static_cast<double>(i) / kRadii;
    const double squareness = figure.crossings(share * figure.largestRadius(), &angles);
    // Far out and square across, an axis comes out sharp; few crossings make few candidates.
    const double quality = squareness * share / (1.0 + 0.02 * static_cast<double>(angles.size()));
    if (!angles.empty() && quality > best_quality) {
      best_quality = quality;
      best = angles;
    }
  }
  std::vector<double> axes;
  for (const double angle : best) {
    double axis = std::fmod(0.5 * (best.front() + angle) + 2.0 * kPi, kPi);
    if (kPi - axis < 1e-6) axis = 0.0;
    axes.push_back(axis);
  }
  std::sort(axes.begin(), axes.end());
  return axes;
}

Eigen::Matrix2d reflection(double axis) {
  Eigen::Matrix2d linear;
  linear << std::cos(2.0 * axis), std::sin(2.0 * axis), std::sin(2.0 * axis), -std::cos(2.0 * axis);
  return linear;
}

}  // namespace

Symmetry findSymmetry(const Drawing& drawing, double tolerance) {
  const std::vector<const Loop*> outline = loopsOf(drawing, false), print = loopsOf(drawing, true);
  if (outline.empty()) throw std::invalid_argument("findSymmetry: the drawing has no outline");
  Symmetry symmetry;
  symmetry.center = materialCentroid(outline);
  const Figure figure(outline, symmetry.center, tolerance);
  const Figure print_figure(print, symmetry.center, tolerance);
  if (isRound(outline, symmetry.center, tolerance)) {
    symmetry.order = 0;
    symmetry.mirror = true;
    const bool round_print = isRound(print, symmetry.center, tolerance);
    symmetry.order_print = round_print ? 0 : rotationOrder(print_figure, 0);
    return symmetry;
  }
  symmetry.order = rotationOrder(figure, 0);
  symmetry.order_print =
      print_figure.empty() ? symmetry.order : rotationOrder(print_figure, symmetry.order);
  for (const double axis : axisCandidates(figure)) {
    if (!figure.mapsToItself(reflection(axis))) continue;
    symmetry.mirror = true;
    symmetry.mirror_axis = axis;
    break;
  }
  return symmetry;
}

}  // namespace planar_bin_picking
