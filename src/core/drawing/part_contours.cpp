// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/part_contours.h"

#include "base/box_tree.h"
#include "base/polygon.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking {
namespace {

/// Points closer than this to the one before carry no shape, only trouble.
constexpr double kSamePointMm = kExactMm;
constexpr std::size_t kPointsMax = 64;                    // of a small loop: more are no overshoot
constexpr double kSizeLeastMm = 1.0, kSizeMostMm = 10e3;  // of a part: others are of another unit

using Points = std::vector<Eigen::Vector2d>;

void dropRepeated(Contour* contour) {
  Points kept;
  for (const Eigen::Vector2d& p : contour->points) {
    if (kept.empty() || (p - kept.back()).norm() > kSamePointMm) kept.push_back(p);
  }
  while (contour->closed && kept.size() > 1 &&
         (kept.front() - kept.back()).norm() <= kSamePointMm) {
    kept.pop_back();
  }
  contour->points = std::move(kept);
}

/// Where the path turns back over itself at b, for less than the tolerance.
bool isSpike(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
             double tolerance) {
  if (std::min((a - b).norm(), (c - b).norm()) > tolerance) return false;
  if ((a - b).dot(c - b) <= 0.0) return false;
  return (a - b).norm() < (c - b).norm() ? distanceToSegment(a, b, c) <= kSamePointMm
                                         : distanceToSegment(c, a, b) <= kSamePointMm;
}

/// Takes spikes off one after the other, also those of several points: what one leaves behind may
/// be a shorter one.
void dropSpikes(Contour* contour, double tolerance) {
  const Points& points = contour->points;
  const std::size_t n = points.size();
  std::vector<std::size_t> before(n), after(n), waiting(n);
  for (std::size_t i = 0; i < n; ++i) {
    before[i] = (i + n - 1) % n;
    after[i] = (i + 1) % n;
    waiting[i] = n - 1 - i;  // taken from the back
  }
  std::vector<bool> gone(n, false);
  std::size_t left = n;
  while (!waiting.empty() && left > 3) {
    const std::size_t i = waiting.back(), a = before[i], c = after[i];
    waiting.pop_back();
    if (gone[i]) continue;
    const bool repeated = (points[i] - points[a]).norm() <= kSamePointMm;
    if (!repeated && !isSpike(points[a], points[i], points[c], tolerance)) continue;
    gone[i] = true;
    --left;
    after[a] = c;
    before[c] = a;
    waiting.insert(waiting.end(), {c, a});
  }
  Points kept;
  for (std::size_t i = 0; i < n; ++i) {
    if (!gone[i]) kept.push_back(points[i]);
  }
  contour->points = std::move(kept);
}

/// The point in which the sides a-b and c-d cross, if they do.
std::optional<Eigen::Vector2d> crossingOf(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                          const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
  const auto cross = [](const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
    return u.x() * v.y() - u.y() * v.x();
  };
  const double across = cross(b - a, d - c);
  if (across == 0.0) return std::nullopt;
  const double s = cross(c - a, d - c) / across, t = cross(c - a, b - a) / across;
  if (s < 0.0 || s > 1.0 || t < 0.0 || t > 1.0) return std::nullopt;
  return a + s * (b - a);
}

/// The first loop shorter than the tolerance after the side from point i: how many points it has,
/// and where the path crosses itself.
std::optional<std::pair<std::size_t, Eigen::Vector2d>> smallLoop(const Points& points,
                                                                 std::size_t i, double tolerance) {
  const std::size_t n = points.size();
  double length = 0.0;
  for (std::size_t k = 2; k < std::min(n - 2, kPointsMax); ++k) {
    const Eigen::Vector2d &last = points[(i + k) % n], &next = points[(i + k + 1) % n];
    length += (last - points[(i + k - 1) % n]).norm();
    if (length > 2.0 * tolerance) return std::nullopt;
    const auto at = crossingOf(points[i], points[(i + 1) % n], last, next);
    if (at && (points[(i + 1) % n] - *at).norm() <= tolerance && (last - *at).norm() <= tolerance)
      return std::make_pair(k, *at);
  }
  return std::nullopt;
}

/// Cuts loops off that the path makes within the tolerance, as where two sides overshoot a corner.
void dropSmallLoops(Contour* contour, double tolerance) {
  std::size_t left = 1000;  // loops; a contour of so many is no overshoot but rubbish
  for (std::size_t i = 0; i < contour->points.size() && left > 0; ++i) {
    const auto loop = smallLoop(contour->points, i, tolerance);
    if (!loop) continue;
    // Turned so that the loop's points, i + 1 to i + k, are the first ones.
    Points& points = contour->points;
    const std::size_t first = (i + 1) % points.size();
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(first), points.end());
    points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(loop->first));
    points.push_back(loop->second);
    i = 0;
    --left;
  }
}

}  // namespace

void smooth(Contour* contour, double tolerance) {
  dropRepeated(contour);
  if (!contour->closed) return;
  if (contour->points.size() >= 4) dropSpikes(contour, tolerance);
  if (contour->points.size() >= 5) dropSmallLoops(contour, tolerance);
  dropRepeated(contour);
}

Eigen::AlignedBox2d boxOf(const std::vector<Eigen::Vector2d>& points) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : points) box.extend(p);
  return box;
}

std::string boxText(const std::vector<Eigen::Vector2d>& points) {
  const Eigen::AlignedBox2d box = boxOf(points);
  return "from " + inMm(box.min()) + " to " + inMm(box.max());
}

void checkCrossings(const std::vector<Contour>& contours) {
  std::vector<Polygon> polygons;
  for (const Contour& contour : contours) polygons.push_back(contour.points);
  const auto crossing = findCrossing(polygons, kSamePointMm);
  if (!crossing) return;
  const Contour &a = contours[crossing->first], &b = contours[crossing->second];
  const std::string what =
      crossing->first == crossing->second
          ? "the contour with " + nameOf(a) + " crosses or touches itself"
          : "the contours with " + nameOf(a) + " and " + nameOf(b) + " cross or touch";
  throw std::runtime_error(
      what + " at " + inMm(crossing->point) +
      ". Correct the drawing, or list the layer in skip_layers if it is no edge");
}

void checkSize(const std::vector<Contour>& contours) {
  Eigen::AlignedBox2d box;
  for (const Contour& contour : contours) box.extend(boxOf(contour.points));
  const double size = box.sizes().maxCoeff();
  if (size >= kSizeLeastMm && size <= kSizeMostMm) return;
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "the part would be " << size
       << " mm large, allowed are 1 mm to 10 m; check the drawing's "
       << "unit ($INSUNITS), or state it in the part file as units";
  throw std::runtime_error(text.str());
}

namespace {

/// Which contours lie in which, where none cross.
class Nesting {
 public:
  explicit Nesting(const std::vector<Contour>& contours)
      : contours_(contours), tree_(boxesOf(contours)) {}

  /// A contour other than these two that holds this one.
  std::optional<std::size_t> around(std::size_t inner, std::size_t except) const {
    const Eigen::Vector2d& p = contours_[inner].points.front();
    std::optional<std::size_t> found;
    tree_.any(Eigen::AlignedBox2d(p, p), [&](std::size_t k) {
      if (k != inner && k != except && contains(contours_[k].points, p))
        found = found ? std::min(*found, k) : k;
      return false;
    });
    return found;
  }

 private:
  static std::vector<Eigen::AlignedBox2d> boxesOf(const std::vector<Contour>& contours) {
    std::vector<Eigen::AlignedBox2d> boxes;
    for (const Contour& contour : contours) boxes.push_back(boxOf(contour.points));
    return boxes;
  }
  const std::vector<Contour>& contours_;
  BoxTree tree_;
};

std::size_t largestOf(const std::vector<Contour>& contours) {
  std::size_t largest = 0;
  double most = 0.0;
  for (std::size_t i = 0; i < contours.size(); ++i) {
    const double area = std::abs(signedArea(contours[i].points));
    if (area > most) {
      most = area;
      largest = i;
    }
  }
  return largest;
}

}  // namespace

std::vector<Loop> classify(const std::vector<Contour>& contours) {
  const std::size_t outer = largestOf(contours);
  const Nesting nesting(contours);
  std::vector<Loop> loops = {{LoopKind::kOuter, true, contours[outer].points}};
  for (std::size_t i = 0; i < contours.size(); ++i) {
    if (i == outer) continue;
    if (!contains(contours[outer].points, contours[i].points.front())) {
      throw std::runtime_error("has several outer contours: with " + nameOf(contours[outer]) + " " +
                               boxText(contours[outer].points) + ", with " + nameOf(contours[i]) +
                               " " + boxText(contours[i].points) +
                               ". Draw one part per file, or list the layer of the others in "
                               "skip_layers");
    }
    if (const auto k = nesting.around(i, outer)) {
      throw std::runtime_error("the contour with " + nameOf(contours[i]) + " " +
                               boxText(contours[i].points) + " lies inside a hole, that with " +
                               nameOf(contours[*k]) + " " + boxText(contours[*k].points) +
                               ". Remove a frame around the part; list the layer of countersinks "
                               "and threads in skip_layers");
    }
    loops.push_back({LoopKind::kHole, true, contours[i].points});
  }
  for (Loop& loop : loops) {
    const bool counter_clockwise = signedArea(loop.points) > 0.0;
    if (counter_clockwise != (loop.kind == LoopKind::kOuter))
      std::reverse(loop.points.begin(), loop.points.end());
  }
  return loops;
}

}  // namespace planar_bin_picking
