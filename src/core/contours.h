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

/// Drops strokes that are drawn twice, in either direction, and crumbs: those shorter than the
/// tolerance that no contour runs through.
std::vector<Stroke> withoutDuplicates(const std::vector<Stroke>& strokes, double tolerance);

/// Joins strokes whose ends meet, or lie within the tolerance where nothing else meets them. Every
/// end must find exactly one other.
/// @throws std::runtime_error  an open contour or a branch: what ends there, and where
std::vector<Contour> chainClosed(const std::vector<Stroke>& strokes, double tolerance);

/// The same where contours may end and meet anywhere, as in prints: they are cut at branches.
std::vector<Contour> chainAny(const std::vector<Stroke>& strokes, double tolerance);

}  // namespace planar_bin_picking
