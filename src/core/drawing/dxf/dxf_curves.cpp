// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/dxf_curves.h"

#include "base/polygon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMaxDepth = 16;  // of halving: 65536 chords, more than any curve needs
/// Places between the ends of a chord at which its distance from the curve is measured. Not at
/// quarters: a wave that passes through its chord there would look straight.
constexpr std::array<double, 3> kProbes = {0.5, 0.21, 0.79};
/// Of the largest distance from the chord: as much of it these places see.
constexpr double kSeen = 0.9;
/// A thousand kilometres: beyond, nothing is known to the accuracy of a part any more.
constexpr double kFarthestMm = 1e9;
constexpr double kStraight = 1e-12;  // of its length, between arc and chord: a straight line
constexpr double kEqual = 1e-9;      // radians; the rounding of angles in degrees stays below

using PlacedCurve = std::function<Eigen::Vector2d(double)>;

/// Collects the chords of one placed curve.
class Flattener {
 public:
  Flattener(PlacedCurve at, double tolerance, std::size_t points_max)
      : at_(std::move(at)), tolerance_(tolerance), points_max_(points_max) {}

  void begin(double t) { append(place(t)); }

  /// From the last point on to that at t1.
  void follow(double t0, double t1) { appendChords(t0, t1, points.back(), place(t1), kMaxDepth); }

  std::vector<Eigen::Vector2d> points;

 private:
  /// Halves the section from t0 to t1 until its chord is close enough; appends the points after p0.
  void appendChords(double t0, double t1, const Eigen::Vector2d& p0, const Eigen::Vector2d& p1,
                    int depth) {
    bool close = true;
    for (const double share : kProbes) {
      close = close && distanceToSegment(place(t0 + share * (t1 - t0)), p0, p1) <= tolerance_;
    }
    if (close || depth == 0) return append(p1);
    const double middle = 0.5 * (t0 + t1);
    const Eigen::Vector2d p = place(middle);
    appendChords(t0, middle, p0, p, depth - 1);
    appendChords(middle, t1, p, p1, depth - 1);
  }

  Eigen::Vector2d place(double t) const {
    const Eigen::Vector2d p = at_(t);
    if (p.cwiseAbs().maxCoeff() <= kFarthestMm && p == p) return p;
    throw std::runtime_error(
        "reaches farther than 1000 km, or has numbers that lead nowhere; check "
        "the drawing's unit, or delete it");
  }

  void append(const Eigen::Vector2d& p) {
    if (points.size() >= points_max_) {
      throw std::runtime_error("needs too many points; is its radius or its unit wrong?");
    }
    points.push_back(p);
  }

  PlacedCurve at_;
  double tolerance_;
  std::size_t points_max_;
};

/// The arc from a to b with the given bulge, at 0 <= s <= 1: the chord from a, of the length that
/// the angle has there, turned by half of what is left of it. Without the center, which is far away
/// where the arc is nearly straight, so that rounding errors in a bulge stay what they are.
Eigen::Vector2d bulgePoint(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double bulge,
                           double s) {
  if (std::abs(bulge) < kStraight) return a + s * (b - a);
  const double half = 2.0 * std::atan(bulge);
  const double length = std::sin(half * s) / std::sin(half);
  return a + length * (Eigen::Rotation2Dd(half * (s - 1.0)) * (b - a));
}

Eigen::Vector2d bulgeCenter(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double bulge) {
  const Eigen::Vector2d chord = b - a, left(-chord.y(), chord.x());
  return 0.5 * (a + b) + (1.0 - bulge * bulge) / (4.0 * bulge) * left;
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

/// Solves low_i x_(i-1) + main_i x_i + high_i x_(i+1) = right_i without pivoting, which is stable
/// here: the main diagonal outweighs the others.
struct Tridiagonal {
  explicit Tridiagonal(std::size_t n)
      : low(n, 0.0), main(n, 1.0), high(n, 0.0), right(n, Eigen::Vector2d::Zero()) {}
  std::vector<double> low, main, high;
  std::vector<Eigen::Vector2d> right;

  std::vector<Eigen::Vector2d> solve() {
    const std::size_t n = main.size();
    for (std::size_t i = 1; i < n; ++i) {
      const double share = low[i] / main[i - 1];
      main[i] -= share * high[i - 1];
      right[i] -= share * right[i - 1];
    }
    for (std::size_t i = n; i-- > 0;) {
      if (i + 1 < n) right[i] -= high[i] * right[i + 1];
      right[i] /= main[i];
    }
    return right;
  }
};

/// One row of the system: curvature is the same on both sides of a point.
void makeSmooth(Tridiagonal* system, std::size_t row, double h0, double h1,
                const Eigen::Vector2d& slope0, const Eigen::Vector2d& slope1) {
  // Divided by the longer section, so that no product of two lengths can overflow.
  const double scale = std::max(h0, h1);
  system->low[row] = h1 / scale;
  system->main[row] = 2.0 * (h0 / scale + h1 / scale);
  system->high[row] = h0 / scale;
  system->right[row] = 3.0 * (h1 / scale * slope0 + h0 / scale * slope1);
}

/// Tangents of the closed cubic spline: the last point is the first again. The system is
/// tridiagonal but for its corners, which the formula of Sherman and Morrison takes in.
std::vector<Eigen::Vector2d> closedTangents(const std::vector<double>& h,
                                            const std::vector<Eigen::Vector2d>& slope) {
  const std::size_t n = h.size();
  Tridiagonal system(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = (i + n - 1) % n;
    makeSmooth(&system, i, h[before], h[i], slope[before], slope[i]);
  }
  const double corner_low = system.low[0], corner_high = system.high[n - 1];
  const double gamma = -system.main[0];
  system.main[0] -= gamma;
  system.main[n - 1] -= corner_low * corner_high / gamma;
  Tridiagonal corners = system;
  corners.right.assign(n, Eigen::Vector2d::Zero());
  corners.right[0].x() = gamma;
  corners.right[n - 1].x() = corner_high;
  std::vector<Eigen::Vector2d> x = system.solve();
  const std::vector<Eigen::Vector2d> z = corners.solve();
  const double below = 1.0 + z[0].x() + corner_low / gamma * z[n - 1].x();
  const Eigen::Vector2d factor = (x[0] + corner_low / gamma * x[n - 1]) / below;
  for (std::size_t i = 0; i < n; ++i) x[i] -= z[i].x() * factor;
  x.push_back(x.front());
  return x;
}

/// Tangents of the cubic spline through `points` at the parameters `u`, C2 everywhere.
std::vector<Eigen::Vector2d> fitTangents(const SplineData& s,
                                         const std::vector<Eigen::Vector2d>& points,
                                         const std::vector<double>& u) {
  std::vector<double> h;
  std::vector<Eigen::Vector2d> slope;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    h.push_back(u[i + 1] - u[i]);
    if (!(h.back() > 0.0) || !std::isfinite(h.back()))
      throw std::runtime_error("has fit points too far apart for a number; delete it");
    slope.emplace_back((points[i + 1] - points[i]) / h.back());
  }
  if (s.closed) return closedTangents(h, slope);
  const std::size_t last = points.size() - 1;
  Tridiagonal system(points.size());
  for (std::size_t i = 1; i < last; ++i)
    makeSmooth(&system, i, h[i - 1], h[i], slope[i - 1], slope[i]);
  const auto end = [&](std::size_t row, std::vector<double>* other, const Eigen::Vector2d& tangent,
                       const Eigen::Vector2d& chord) {
    const bool known = tangent.norm() > 0.0;
    system.main[row] = known ? 1.0 : 2.0;
    (*other)[row] = known ? 0.0 : 1.0;
    system.right[row] = known ? tangent.normalized() : Eigen::Vector2d(3.0 * chord);
  };
  end(0, &system.high, s.start_tangent, slope.front());
  end(last, &system.low, s.end_tangent, slope.back());
  return system.solve();
}

Curve interpolate(const SplineData& s) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& p : s.fit_points) {
    if (points.empty() || (p - points.back()).norm() > 0.0) points.push_back(p);
  }
  if (s.closed && points.size() > 1 && points.front() != points.back())
    points.push_back(points.front());
  if (points.size() < (s.closed ? 4u : 2u)) throw std::runtime_error("has too few fit points");
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
  Curve curve;
  curve.breaks = u;
  curve.at = at;
  return curve;
}

}  // namespace

Curve makeLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  Curve curve;
  curve.breaks = {0.0, 1.0};
  // Both ends exactly as they stand in the file.
  curve.at = [from, to](double t) -> Eigen::Vector2d { return (1.0 - t) * from + t * to; };
  return curve;
}

Curve makeEllipse(const Eigen::Vector2d& center, const Eigen::Vector2d& major,
                  const Eigen::Vector2d& minor, double start, double end) {
  if (std::abs(end - start) < kEqual) return {};
  double span = std::fmod(end - start, 2.0 * kPi);
  if (span <= kEqual) span += 2.0 * kPi;
  const int parts = std::max(1, static_cast<int>(std::ceil(span / (0.5 * kPi) - 1e-9)));
  Curve curve;
  for (int i = 0; i <= parts; ++i) curve.breaks.push_back(start + span * i / parts);
  curve.at = [center, major, minor](double t) -> Eigen::Vector2d {
    return center + std::cos(t) * major + std::sin(t) * minor;
  };
  curve.closed = std::abs(span - 2.0 * kPi) < kEqual;
  curve.centers = {center};
  return curve;
}

Curve makePolyline(std::vector<BulgeVertex> vertices, bool closed) {
  if (closed && !vertices.empty()) vertices.push_back(vertices.front());
  if (vertices.size() < 2) return {};
  Curve curve;
  curve.closed = closed;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    curve.breaks.push_back(static_cast<double>(i));
    if (i + 1 < vertices.size() && vertices[i].bulge != 0.0) {
      curve.centers.push_back(
          bulgeCenter(vertices[i].position, vertices[i + 1].position, vertices[i].bulge));
    }
  }
  curve.at = [vertices](double t) -> Eigen::Vector2d {
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
                                     double tolerance, std::size_t points_max) {
  if (curve.breaks.empty()) return {};
  const PlacedCurve at = [&](double t) -> Eigen::Vector2d { return placement * curve.at(t); };
  Flattener flattener(at, kSeen * tolerance, points_max);
  flattener.begin(curve.breaks.front());
  for (std::size_t i = 1; i < curve.breaks.size(); ++i) {
    flattener.follow(curve.breaks[i - 1], curve.breaks[i]);
  }
  return std::move(flattener.points);
}

}  // namespace planar_bin_picking
