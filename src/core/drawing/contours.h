// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Single lines and arcs, drawn in any order and direction -> contours. Lengths in mm.

#include <Eigen/Core>

#include <string>
#include <vector>

namespace planar_bin_picking {

/// One entity of the drawing as a polyline.
struct Stroke {
  std::string type, layer;  ///< for messages
  std::vector<Eigen::Vector2d> points;
  bool closed = false;                   ///< the last point is the first again
  std::vector<Eigen::Vector2d> centers;  ///< of its arcs
  std::string annotation;  ///< its line type, where this says that it is no edge and it is kept
};

/// Strokes joined end to end.
struct Contour {
  std::string type, layer;  ///< of its first stroke
  bool closed = false;      ///< the last point joins the first (it is not repeated)
  std::vector<Eigen::Vector2d> points;
};

/// `the LINE on layer "CUT"`
template <class Drawn>
std::string nameOf(const Drawn& drawn) {
  return "the " + drawn.type + " on layer \"" + drawn.layer + "\"";
}

/// `(12.345, 6.700) mm`
std::string inMm(const Eigen::Vector2d& point);

/// Ends this close were drawn to meet; further apart, up to the join tolerance, they were meant to.
inline constexpr double kExactMm = 1e-4;

/// Which ends of strokes meet. End 2 i is the first point of stroke i, end 2 i + 1 its last. Closed
/// strokes meet nothing.
class Joints {
 public:
  /// Ends that lie within the tolerance meet where nothing else meets them.
  Joints(const std::vector<Stroke>& strokes, double tolerance);

  const Eigen::Vector2d& at(std::size_t end) const { return ends_[end]; }
  std::size_t count() const { return ends_.size(); }
  /// All ends that meet in this one, itself included, in ascending order.
  const std::vector<std::size_t>& meeting(std::size_t end) const { return members_[parent_[end]]; }
  /// Nothing meets this end.
  bool isLoose(std::size_t end) const { return !closed_[end / 2] && meeting(end).size() == 1; }
  /// Where they meet: two straight ones in the point to which they lead.
  Eigen::Vector2d joint(std::size_t end) const;

 private:
  void joinClose(const std::vector<std::size_t>& ends, double tolerance);
  std::size_t root(std::size_t end);
  void collect();

  std::vector<Eigen::Vector2d> ends_;
  std::vector<Eigen::Vector2d> directions_;  ///< of straight strokes; zero of curves
  double tolerance_;
  std::vector<bool> closed_;
  std::vector<std::size_t> parent_;
  std::vector<std::vector<std::size_t>> members_;
};

/// Joins strokes whose ends meet, or lie within the tolerance where nothing else meets them. Every
/// end must find exactly one other.
/// @throws std::runtime_error  an open contour or a branch: what ends there, and where
std::vector<Contour> chainClosed(const std::vector<Stroke>& strokes, double tolerance);

/// The same where contours may end and meet anywhere, as in prints: they are cut at branches.
std::vector<Contour> chainAny(const std::vector<Stroke>& strokes, double tolerance);

}  // namespace planar_bin_picking
