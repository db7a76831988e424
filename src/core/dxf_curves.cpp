// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dxf_curves.h"

#include "polygon.h"

#include <Eigen/SparseLU>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;

using PlacedCurve = std::function<Eigen::Vector2d(double)>;

/// Halves the stretch from t0 to t1 until its chord is close enough; appends the points after `p0`.
void appendChords(const PlacedCurve& at, double t0, double t1, const Eigen::Vector2d& p0,
                  const Eigen::Vector2d& p1, double tolerance, int depth,
                  std::vector<Eigen::Vector2d>* points) {
  // Not at quarters: a wave that passes through its chord there would look straight.
  bool close = true;
  for (const double share : {0.5, 0.21, 0.79}) {
    close = close && distanceToSegment(at(t0 + share * (t1 - t0)), p0, p1) <= tolerance;
  }
  if (close || depth == 0) {
    points->push_back(p1);
    return;
  }
  const double middle = 0.5 * (t0 + t1);
  const Eigen::Vector2d p = at(middle);
  appendChords(at, t0, middle, p0, p, tolerance, depth - 1, points);
  appendChords(at, middle, t1, p, p1, tolerance, depth - 1, points);
}

/// The arc from a to b with the given bulge, at 0 <= s <= 1.
Eigen::Vector2d bulgePoint(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double bulge,
                           double s) {
  const Eigen::Vector2d chord = b - a;
  if (bulge == 0.0) return a + s * chord;
  const Eigen::Vector2d left(-chord.y(), chord.x());
  const Eigen::Vector2d center = 0.5 * (a + b) + (1.0 - bulge * bulge) / (4.0 * bulge) * left;
  return center + Eigen::Rotation2Dd(4.0 * std::atan(bulge) * s) * (a - center);
}

/// A point of the B-spline by de Boor's algorithm in homogeneous coordinates.
Eigen::Vector2d deBoor(const SplineData& s, double t) {
  const int p = s.degree;
  const auto first = s.knots.begin() + p;
  const auto last = s.knots.begin() + static_cast<std::ptrdiff_t>(s.control_points.size());
  // The span that holds t; the end of the domain belongs to the last span that is not empty.
  auto above = std::upper_bound(first, last, t);
  if (above == last) above = std::lower_bound(first, last, *last);
  const int span = static_cast<int>(above - s.knots.begin()) - 1;
  std::vector<Eigen::Vector3d> d;
  for (int i = span - p; i <= span; ++i) {
    const Eigen::Vector2d weighted = s.weights[i] * s.control_points[i];
    d.emplace_back(weighted.x(), weighted.y(), s.weights[i]);
  }
  for (int round = 1; round <= p; ++round) {
    for (int i = p; i >= round; --i) {
      const double low = s.knots[span - p + i], high = s.knots[span + 1 + i - round];
      const double share = high > low ? (t - low) / (high - low) : 0.0;
      d[i] = (1.0 - share) * d[i - 1] + share * d[i];
    }
  }
  return d[p].hnormalized();
}

void checkSpline(const SplineData& s) {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw std::runtime_error(what + "; the file is damaged, export it again");
  };
  const std::size_t degree = static_cast<std::size_t>(std::max(s.degree, 0));
  require(s.degree >= 1 && s.degree <= 25, "has degree " + std::to_string(s.degree));
  require(s.control_points.size() > degree, "has too few control points for its degree");
  require(s.knots.size() == s.control_points.size() + degree + 1,
          "has " + std::to_string(s.knots.size()) + " knots where its " +
              std::to_string(s.control_points.size()) + " control points need " +
              std::to_string(s.control_points.size() + degree + 1));
  require(std::is_sorted(s.knots.begin(), s.knots.end()), "has knots that do not ascend");
  require(s.knots[degree] < s.knots[s.control_points.size()], "has knots that are all equal");
  require(s.weights.size() == s.control_points.size(), "has not one weight per control point");
  require(std::all_of(s.weights.begin(), s.weights.end(), [](double w) { return w > 0.0; }),
          "has a weight that is not greater than 0");
}

/// Tangents of the cubic spline through `points` at the parameters `u`, C2 everywhere.
std::vector<Eigen::Vector2d> fitTangents(const SplineData& s,
                                         const std::vector<Eigen::Vector2d>& points,
                                         const std::vector<double>& u) {
  const int n = static_cast<int>(points.size()), last = n - 1;
  std::vector<Eigen::Triplet<double>> a;
  Eigen::MatrixX2d b = Eigen::MatrixX2d::Zero(n, 2);
  const auto slope = [&](int i) {
    return Eigen::Vector2d((points[i + 1] - points[i]) / (u[i + 1] - u[i]));
  };
  const auto smooth = [&](int row, int before, int after) {  // C2 between two stretches
    const double h0 = u[before + 1] - u[before], h1 = u[after + 1] - u[after];
    a.insert(a.end(), {{row, before, h1},
                       {row, before + 1, 2.0 * h0},
                       {row, after, 2.0 * h1},
                       {row, after + 1, h0}});
    b.row(row) = 3.0 * (h1 * slope(before) + h0 * slope(after));
  };
  for (int i = 1; i < last; ++i) smooth(i, i - 1, i);
  if (s.closed) {
    smooth(0, last - 1, 0);
    a.insert(a.end(), {{last, last, 1.0}, {last, 0, -1.0}});
  } else {
    const auto end = [&](int row, int other, const Eigen::Vector2d& tangent,
                         const Eigen::Vector2d& chord) {
      const bool known = tangent.norm() > 0.0;
      a.push_back({row, row, known ? 1.0 : 2.0});
      if (!known) a.push_back({row, other, 1.0});
      b.row(row) = known ? tangent.normalized() : Eigen::Vector2d(3.0 * chord);
    };
    end(0, 1, s.start_tangent, slope(0));
    end(last, last - 1, s.end_tangent, slope(last - 1));
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(a.begin(), a.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(matrix);
  const Eigen::MatrixX2d m = solver.solve(b);
  std::vector<Eigen::Vector2d> tangents;
  for (int i = 0; i < n; ++i) tangents.emplace_back(m.row(i));
  return tangents;
}

Curve interpolate(const SplineData& s) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& p : s.fit_points) {
    if (points.empty() || (p - points.back()).norm() > 0.0) points.push_back(p);
  }
  if (s.closed && points.size() > 1 && points.front() != points.back())
    points.push_back(points.front());
  if (points.size() < (s.closed ? 4 : 2)) throw std::runtime_error("has too few fit points");
  std::vector<double> u = {0.0};
  for (std::size_t i = 1; i < points.size(); ++i) {
    u.push_back(u.back() + (points[i] - points[i - 1]).norm());
  }
  const std::vector<Eigen::Vector2d> tangents = fitTangents(s, points, u);
  const auto at = [points, tangents, u](double t) -> Eigen::Vector2d {
    const auto above = std::upper_bound(u.begin() + 1, u.end() - 1, t);
    const std::size_t i = static_cast<std::size_t>(above - u.begin()) - 1;
    const double h = u[i + 1] - u[i], s = (t - u[i]) / h, r = 1.0 - s;
    return r * r * ((1.0 + 2.0 * s) * points[i] + s * h * tangents[i]) +
           s * s * ((1.0 + 2.0 * r) * points[i + 1] - r * h * tangents[i + 1]);
  };
  return {u, at};
}

}  // namespace

Curve makeLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return {{0.0, 1.0}, [from, to](double t) -> Eigen::Vector2d { return from + t * (to - from); }};
}

Curve makeEllipse(const Eigen::Vector2d& center, const Eigen::Vector2d& major,
                  const Eigen::Vector2d& minor, double start, double end) {
  double span = std::fmod(end - start, 2.0 * kPi);
  if (span <= 1e-9) span += 2.0 * kPi;
  const int parts = std::max(1, static_cast<int>(std::ceil(span / (0.5 * kPi) - 1e-9)));
  Curve curve;
  for (int i = 0; i <= parts; ++i) curve.breaks.push_back(start + span * i / parts);
  curve.at = [center, major, minor](double t) -> Eigen::Vector2d {
    return center + std::cos(t) * major + std::sin(t) * minor;
  };
  return curve;
}

Curve makePolyline(std::vector<BulgeVertex> vertices, bool closed) {
  if (closed && !vertices.empty()) vertices.push_back(vertices.front());
  if (vertices.size() < 2) return {};
  Curve curve;
  for (std::size_t i = 0; i < vertices.size(); ++i) curve.breaks.push_back(static_cast<double>(i));
  curve.at = [vertices](double t) {
    const std::size_t i = std::min(static_cast<std::size_t>(t), vertices.size() - 2);
    return bulgePoint(vertices[i].position, vertices[i + 1].position, vertices[i].bulge,
                      t - static_cast<double>(i));
  };
  return curve;
}

Curve makeSpline(const SplineData& spline) {
  if (spline.control_points.empty()) return interpolate(spline);
  checkSpline(spline);
  Curve curve;
  const auto first = spline.knots.begin() + spline.degree;
  const auto last =
      spline.knots.begin() + static_cast<std::ptrdiff_t>(spline.control_points.size());
  std::unique_copy(first, last + 1, std::back_inserter(curve.breaks));
  curve.at = [spline](double t) { return deBoor(spline, t); };
  return curve;
}

std::vector<Eigen::Vector2d> flatten(const Curve& curve, const Eigen::Affine2d& placement,
                                     double tolerance) {
  if (curve.breaks.empty()) return {};
  constexpr int kMaxDepth = 16;
  const PlacedCurve at = [&](double t) -> Eigen::Vector2d { return placement * curve.at(t); };
  std::vector<Eigen::Vector2d> points = {at(curve.breaks.front())};
  for (std::size_t i = 1; i < curve.breaks.size(); ++i) {
    const double t0 = curve.breaks[i - 1], t1 = curve.breaks[i];
    // Three samples see nearly, not quite, the largest distance from the chord.
    appendChords(at, t0, t1, points.back(), at(t1), 0.9 * tolerance, kMaxDepth, &points);
  }
  return points;
}

}  // namespace planar_bin_picking
