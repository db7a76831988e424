// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/drawing/symmetry.h"

#include "base/polygon.h"
#include "drawing/figure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMaxOrder = 360;  ///< finer teeth than one degree count as a circle or as none
/// Of the circle that is chosen to look for mirror axes: by how much a crossing more lowers its
/// merit.
constexpr double kPerCrossing = 0.02;
constexpr int kRadii = 200;          // circles tried: half a per cent of the largest radius apart
constexpr int kFallbackPerLoop = 9;  // circles per loop, where none of these crosses the figure
constexpr double kSameAxis = 1e-6;   // radians: an axis at pi but for rounding is that at 0

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

/// Turns by k / n of a full one, each tried once: half a turn is one of every even order.
class Turns {
 public:
  explicit Turns(const Figure& figure) : figure_(figure) {}

  /// The largest order of rotation; `of` = 0 tries all, else its divisors.
  int largestOrder(int of) {
    for (int order = of == 0 ? kMaxOrder : of; order > 1; --order) {
      if ((of == 0 || of % order == 0) && hasOrder(order)) return order;
    }
    return 1;
  }

 private:
  /// Whether all turns of that order map the figure to itself. One small turn moves a round figure
  /// by less than the tolerance whether or not it is symmetric; the largest turns tell.
  bool hasOrder(int order) {
    for (int k = order / 2; k > 0; --k) {
      if (!maps(k / std::gcd(k, order), order / std::gcd(k, order))) return false;
    }
    return true;
  }

  bool maps(int k, int n) {
    const auto [it, is_new] = known_.try_emplace({k, n}, false);
    if (is_new) {
      const Eigen::Rotation2Dd turn(2.0 * kPi * k / n);
      it->second = figure_.mapsToItself(turn.toRotationMatrix());
    }
    return it->second;
  }

  const Figure& figure_;
  std::map<std::pair<int, int>, bool> known_;
};

int rotationOrder(const Figure& figure, int of) { return Turns(figure).largestOrder(of); }

/// Axes that could mirror the figure: a mirror maps its crossings with a circle to one another.
std::vector<double> axisCandidates(const Figure& figure) {
  std::vector<double> best;
  double best_quality = 0.0;
  const auto look = [&](double radius) {
    std::vector<double> angles;
    const double squareness = figure.crossings(radius, &angles);
    // Far out and square across, an axis comes out sharp; few crossings make few candidates.
    const double quality = squareness * (radius / figure.largestRadius()) /
                           (1.0 + kPerCrossing * static_cast<double>(angles.size()));
    if (!angles.empty() && quality > best_quality) {
      best_quality = quality;
      best = angles;
    }
  };
  for (int i = 1; i < kRadii; ++i) look(static_cast<double>(i) / kRadii * figure.largestRadius());
  // A shallow flat of a disk may lie between two of them.
  if (best.empty()) {
    for (const double radius : figure.crossedRadii(kFallbackPerLoop)) look(radius);
  }
  std::vector<double> axes;
  for (const double angle : best) {
    double axis = std::fmod(0.5 * (best.front() + angle) + 2.0 * kPi, kPi);
    if (kPi - axis < kSameAxis) axis = 0.0;
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
