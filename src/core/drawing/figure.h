// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Loops about a centre, prepared for the one question of the search for symmetry: does a turn or a
/// mirroring map them to themselves?

#include "planar_bin_picking/drawing/drawing.h"

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace planar_bin_picking {

/// Square cells of the plane, each with a list of what lies in or near it.
template <class Thing>
class PlaneIndex {
 public:
  explicit PlaneIndex(double cell = 1.0) : cell_(cell) {}

  void add(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const Thing& thing) {
    const Eigen::Vector2i first = cellOf(low), last = cellOf(high);
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) cells_[keyOf({x, y})].push_back(thing);
    }
  }
  const std::vector<Thing>& at(const Eigen::Vector2d& point) const {
    static const std::vector<Thing> kNone;
    const auto it = cells_.find(keyOf(cellOf(point)));
    return it == cells_.end() ? kNone : it->second;
  }

 private:
  Eigen::Vector2i cellOf(const Eigen::Vector2d& p) const {
    return (p / cell_).array().floor().matrix().template cast<int>();
  }
  static std::uint64_t keyOf(const Eigen::Vector2i& cell) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell.y())) << 32) |
           static_cast<std::uint32_t>(cell.x());
  }

  double cell_;
  std::unordered_map<std::uint64_t, std::vector<Thing>> cells_;
};

class Figure {
 public:
  using Side = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

  /// @param tolerance  how far, in metres, a mapped point may lie off the figure
  Figure(const std::vector<const Loop*>& loops, const Eigen::Vector2d& center, double tolerance);

  bool empty() const { return sides_.empty(); }
  double largestRadius() const { return largest_radius_; }
  /// Of circles about the centre that some loop of the figure crosses, evenly from its nearest
  /// point to its farthest.
  std::vector<double> crossedRadii(int per_loop) const;
  bool mapsToItself(const Eigen::Matrix2d& linear) const;

  /// The angles at which the figure crosses a circle about the centre, and how squarely: the least
  /// sine between line and circle.
  double crossings(double radius, std::vector<double>* angles) const;

 private:
  struct Circle {
    Eigen::Vector2d center = Eigen::Vector2d::Zero();
    double radius = 0.0;
  };
  /// What a loop takes up in the lists below.
  struct Piece {
    std::size_t first_side = 0, last_side = 0, first_sample = 0, last_sample = 0;
    double nearest = 0.0, farthest = 0.0;  ///< from the centre
    bool round = false;
    Circle circle;  ///< where it is round
  };

  void addLines(double cell);
  void addSamples(Piece* piece, double spacing);
  void addIfRound(Piece* piece, bool closed);
  bool holds(const Eigen::Vector2d& point) const;
  bool holds(const Circle& circle) const;

  double tolerance_, largest_radius_ = 0.0;
  std::vector<Piece> pieces_;
  std::vector<Side> sides_;
  std::vector<Eigen::Vector2d> samples_;
  PlaneIndex<Side> lines_;
  PlaneIndex<Circle> circles_;
};

}  // namespace planar_bin_picking
