// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "contours.h"

#include "polygon.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <iomanip>
#include <limits>
#include <locale>
#include <map>
#include <numeric>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

using Points = std::vector<Eigen::Vector2d>;

double lengthOf(const Points& points) {
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

double distanceTo(const Points& polyline, const Eigen::Vector2d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < polyline.size(); ++i) {
    nearest = std::min(nearest, distanceToSegment(p, polyline[i - 1], polyline[i]));
  }
  return nearest;
}

bool liesOn(const Points& points, const Points& polyline, double tolerance) {
  return std::all_of(points.begin(), points.end(), [&](const Eigen::Vector2d& p) {
    return distanceTo(polyline, p) <= tolerance;
  });
}

Eigen::AlignedBox2d boxOf(const Points& points) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : points) box.extend(p);
  return box;
}

/// Whether two strokes cover the same points: ends alone do not tell an arc from its chord.
bool coverTheSame(const Stroke& s, const Stroke& t, double tolerance) {
  const Eigen::AlignedBox2d a = boxOf(s.points), b = boxOf(t.points);
  return (a.min() - b.min()).norm() <= tolerance && (a.max() - b.max()).norm() <= tolerance &&
         liesOn(s.points, t.points, tolerance) && liesOn(t.points, s.points, tolerance);
}

/// Ends this close were drawn to meet; further apart, up to the tolerance, they were meant to.
constexpr double kExactMm = 1e-4;

/// Which ends of strokes meet. End 2 i is the first point of stroke i, end 2 i + 1 its last.
class Joints {
 public:
  Joints(const std::vector<Stroke>& strokes, double tolerance) {
    for (const Stroke& stroke : strokes) {
      ends_.push_back(stroke.points.front());
      ends_.push_back(stroke.points.back());
    }
    parent_.resize(ends_.size());
    std::iota(parent_.begin(), parent_.end(), 0);
    joinClose(parent_, kExactMm);
    collect();
    // An outline of lines shorter than the tolerance must not collapse: only loose ends reach far.
    std::vector<std::size_t> loose;
    for (std::size_t end = 0; end < ends_.size(); ++end) {
      if (meeting(end).size() == 1) loose.push_back(end);
    }
    joinClose(loose, tolerance);
    collect();
  }

  const Eigen::Vector2d& at(std::size_t end) const { return ends_[end]; }
  std::size_t count() const { return ends_.size(); }
  /// All ends that meet in this one, itself included, in ascending order.
  const std::vector<std::size_t>& meeting(std::size_t end) const { return members_[root(end)]; }
  /// Where they meet.
  Eigen::Vector2d joint(std::size_t end) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const std::size_t other : meeting(end)) sum += ends_[other];
    return sum / static_cast<double>(meeting(end).size());
  }

 private:
  void joinClose(std::vector<std::size_t> from_left, double tolerance) {
    std::sort(from_left.begin(), from_left.end(), [this](std::size_t a, std::size_t b) {
      return ends_[a].x() != ends_[b].x() ? ends_[a].x() < ends_[b].x() : a < b;
    });
    for (std::size_t i = 0; i < from_left.size(); ++i) {
      for (std::size_t j = i + 1; j < from_left.size(); ++j) {
        const Eigen::Vector2d& p = ends_[from_left[i]];
        const Eigen::Vector2d& q = ends_[from_left[j]];
        if (q.x() - p.x() > tolerance) break;
        if ((q - p).norm() <= tolerance) parent_[root(from_left[j])] = root(from_left[i]);
      }
    }
  }

  void collect() {
    members_.assign(ends_.size(), {});
    for (std::size_t end = 0; end < ends_.size(); ++end) members_[root(end)].push_back(end);
  }

  std::size_t root(std::size_t end) const {
    while (parent_[end] != end) end = parent_[end];
    return end;
  }

  Points ends_;
  std::vector<std::size_t> parent_;
  std::vector<std::vector<std::size_t>> members_;
};

[[noreturn]] void throwOpen(const std::vector<Stroke>& strokes, const Joints& joints,
                            std::size_t end) {
  std::ostringstream text;
  text << "open contour: " << nameOf(strokes[end / 2]) << " ends alone at " << inMm(joints.at(end));
  std::size_t nearest = end;
  double gap = std::numeric_limits<double>::infinity();
  for (std::size_t other = 0; other < joints.count(); ++other) {
    const double distance = (joints.at(other) - joints.at(end)).norm();
    if (other != end && joints.meeting(other).size() == 1 && distance < gap) {
      gap = distance;
      nearest = other;
    }
  }
  if (nearest != end) {
    text.imbue(std::locale::classic());
    text << "; the next loose end is " << std::fixed << std::setprecision(3) << gap
         << " mm away, of " << nameOf(strokes[nearest / 2]) << " at " << inMm(joints.at(nearest));
  }
  text << ". Close the gap in the drawing, or list the layer in skip_layers if it is no edge";
  throw std::runtime_error(text.str());
}

[[noreturn]] void throwBranch(const std::vector<Stroke>& strokes, const Joints& joints,
                              std::size_t end) {
  std::string text = "the contour branches at " + inMm(joints.joint(end)) + ", where ";
  std::string names;
  for (const std::size_t other : joints.meeting(end)) {
    names += (names.empty() ? "" : ", ") + nameOf(strokes[other / 2]);
  }
  throw std::runtime_error(
      text + names + " meet. Remove what is no edge of the part, or list its layer in skip_layers");
}

/// Walks along strokes from an end, through joints where exactly two meet.
struct Walk {
  const std::vector<Stroke>& strokes;
  const Joints& joints;
  std::vector<bool> used;

  /// Appends the stroke that begins at `start` and those that follow; true if it came round.
  bool follow(std::size_t start, Points* points) {
    for (std::size_t end = start;;) {
      const std::size_t index = end / 2;
      used[index] = true;
      Points next = strokes[index].points;
      if (end % 2 == 1) std::reverse(next.begin(), next.end());
      next.front() = joints.joint(end);
      next.back() = joints.joint(end ^ 1);
      points->insert(points->end(), next.begin() + (points->empty() ? 0 : 1), next.end());
      const std::vector<std::size_t>& meeting = joints.meeting(end ^ 1);
      if (meeting.size() != 2) return false;
      end = meeting[0] == (end ^ 1) ? meeting[1] : meeting[0];
      if (end == start) return true;
      if (used[end / 2]) return false;
    }
  }

  Contour from(std::size_t index) {
    Contour contour{strokes[index].type, strokes[index].layer, false, {}};
    contour.closed = follow(2 * index, &contour.points);
    if (contour.closed) {
      contour.points.pop_back();
      return contour;
    }
    // It came to an end: go the other way from where it began.
    const std::vector<std::size_t>& meeting = joints.meeting(2 * index);
    if (meeting.size() != 2) return contour;
    const std::size_t other = meeting[0] == 2 * index ? meeting[1] : meeting[0];
    if (used[other / 2]) return contour;
    Points before;
    follow(other, &before);
    std::reverse(before.begin(), before.end());
    contour.points.insert(contour.points.begin(), before.begin(), before.end() - 1);
    return contour;
  }
};

std::vector<Contour> chain(const std::vector<Stroke>& strokes, const Joints& joints) {
  Walk walk{strokes, joints, std::vector<bool>(strokes.size(), false)};
  std::vector<Contour> contours;
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    if (!walk.used[i]) contours.push_back(walk.from(i));
  }
  return contours;
}

/// Drops what has no length, and strokes shorter than the tolerance that no contour runs through.
std::vector<Stroke> withoutCrumbs(const std::vector<Stroke>& strokes, double tolerance) {
  std::vector<Stroke> lines, kept;
  for (const Stroke& stroke : strokes) {
    if (lengthOf(stroke.points) > kExactMm) lines.push_back(stroke);
  }
  const Joints joints(lines, kExactMm);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto &first = joints.meeting(2 * i), &last = joints.meeting(2 * i + 1);
    const bool through = first.size() == 2 && last.size() == 2 && first != last;
    if (through || lengthOf(lines[i].points) > tolerance) kept.push_back(lines[i]);
  }
  return kept;
}

}  // namespace

std::string inMm(const Eigen::Vector2d& point) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  // Adding zero turns -0 into 0.
  text << std::fixed << std::setprecision(3) << "(" << point.x() + 0.0 << ", " << point.y() + 0.0
       << ") mm";
  return text.str();
}

std::vector<Stroke> withoutDuplicates(const std::vector<Stroke>& strokes, double tolerance) {
  const std::vector<Stroke> lines = withoutCrumbs(strokes, tolerance);
  std::vector<Stroke> kept;
  std::multimap<double, std::size_t> by_left;  // index in kept by the left end of its box
  for (const Stroke& stroke : lines) {
    // A neighbour as short as the tolerance must not pass for the same line.
    const double near = std::min(tolerance, 0.2 * lengthOf(stroke.points));
    const double left = boxOf(stroke.points).min().x();
    const bool twice = std::any_of(
        by_left.lower_bound(left - near), by_left.upper_bound(left + near),
        [&](const auto& other) { return coverTheSame(stroke, kept[other.second], near); });
    if (twice) continue;
    by_left.emplace(left, kept.size());
    kept.push_back(stroke);
  }
  return kept;
}

std::vector<Contour> chainClosed(const std::vector<Stroke>& strokes, double tolerance) {
  const Joints joints(strokes, tolerance);
  for (std::size_t end = 0; end < joints.count(); ++end) {
    if (joints.meeting(end).size() == 1) throwOpen(strokes, joints, end);
  }
  for (std::size_t end = 0; end < joints.count(); ++end) {
    if (joints.meeting(end).size() > 2) throwBranch(strokes, joints, end);
  }
  return chain(strokes, joints);
}

std::vector<Contour> chainAny(const std::vector<Stroke>& strokes, double tolerance) {
  return chain(strokes, Joints(strokes, tolerance));
}

}  // namespace planar_bin_picking
