// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/contours.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <locale>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// Sine of the angle between two lines: where it is flatter, the point at which they meet lies far
/// off and is none that anybody drew.
constexpr double kFlat = 0.1;
/// A cell's diagonal is this share of the tolerance, so that rounding does not put ends into one
/// that are farther apart.
constexpr double kBelow = 0.999;
constexpr int kReach = 2;  // cells that a tolerance spans

using Points = std::vector<Eigen::Vector2d>;

/// Which way a stroke runs at its end; zero where it is bent there.
Eigen::Vector2d endDirection(const Stroke& stroke, bool last) {
  const Points& points = stroke.points;
  if (points.size() != 2 && !stroke.centers.empty()) return Eigen::Vector2d::Zero();
  const std::size_t n = points.size();
  return last ? Eigen::Vector2d(points[n - 1] - points[n - 2])
              : Eigen::Vector2d(points[1] - points[0]);
}

/// The point to which two lines lead from their ends; nothing where they meet at a flat angle, or
/// the ends are at the same place already.
std::optional<Eigen::Vector2d> cornerOf(const Eigen::Vector2d& a, const Eigen::Vector2d& along_a,
                                        const Eigen::Vector2d& b, const Eigen::Vector2d& along_b) {
  const double across = along_a.x() * along_b.y() - along_a.y() * along_b.x();
  if ((a - b).norm() <= kExactMm || std::abs(across) <= kFlat * along_a.norm() * along_b.norm())
    return std::nullopt;
  const Eigen::Vector2d between = b - a;
  return a + (between.x() * along_b.y() - between.y() * along_b.x()) / across * along_a;
}

[[noreturn]] void throwOpen(const std::vector<Stroke>& strokes, const Joints& joints,
                            std::size_t end) {
  std::ostringstream text;
  text << "open contour: " << nameOf(strokes[end / 2]) << " ends alone at " << inMm(joints.at(end));
  std::size_t nearest = end;
  double gap = std::numeric_limits<double>::infinity();
  for (std::size_t other = 0; other < joints.count(); ++other) {
    const double distance = (joints.at(other) - joints.at(end)).norm();
    if (other != end && joints.isLoose(other) && distance < gap) {
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
    if (strokes[index].closed) {
      used[index] = true;
      contour.points = strokes[index].points;
      contour.points.pop_back();
      contour.closed = true;
      return contour;
    }
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

}  // namespace

std::string inMm(const Eigen::Vector2d& point) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  // Adding zero turns -0 into 0.
  text << std::fixed << std::setprecision(3) << "(" << point.x() + 0.0 << ", " << point.y() + 0.0
       << ") mm";
  return text.str();
}

Joints::Joints(const std::vector<Stroke>& strokes, double tolerance) : tolerance_(tolerance) {
  std::vector<std::size_t> open;
  for (const Stroke& stroke : strokes) {
    const Points& points = stroke.points;
    for (const bool last : {false, true}) {
      if (!stroke.closed) open.push_back(ends_.size());
      ends_.push_back(last ? points.back() : points.front());
      directions_.push_back(endDirection(stroke, last));
    }
    closed_.push_back(stroke.closed);
  }
  parent_.resize(ends_.size());
  std::iota(parent_.begin(), parent_.end(), 0);
  joinClose(open, kExactMm);
  collect();
  // An outline of lines shorter than the tolerance must not collapse: only loose ends reach far.
  std::vector<std::size_t> loose;
  for (const std::size_t end : open) {
    if (meeting(end).size() == 1) loose.push_back(end);
  }
  joinClose(loose, tolerance);
  collect();
}

Eigen::Vector2d Joints::joint(std::size_t end) const {
  if (meeting(end).size() == 2) {
    const std::size_t a = meeting(end)[0], b = meeting(end)[1];
    const auto corner = cornerOf(ends_[a], directions_[a], ends_[b], directions_[b]);
    // Where they lead must be as near as their ends: lines at a flat angle meet far away.
    if (corner && (*corner - ends_[a]).norm() <= tolerance_ &&
        (*corner - ends_[b]).norm() <= tolerance_)
      return *corner;
  }
  // Relative to one of them: far from the origin a sum would lose digits.
  const Eigen::Vector2d& base = ends_[meeting(end).front()];
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const std::size_t other : meeting(end)) sum += ends_[other] - base;
  return base + sum / static_cast<double>(meeting(end).size());
}

void Joints::joinClose(const std::vector<std::size_t>& ends, double tolerance) {
  // In cells so small that all ends in one are close, one of them stands for all; ends of cells
  // nearby are compared until two are close. So a thousand ends in a place, or at one x, cost
  // little.
  const double cell = tolerance / std::sqrt(2.0) * kBelow;
  const auto cellOf = [&](std::size_t end) {
    return std::make_pair(static_cast<long>(std::floor(ends_[end].x() / cell)),
                          static_cast<long>(std::floor(ends_[end].y() / cell)));
  };
  std::map<std::pair<long, long>, std::vector<std::size_t>> cells;
  for (const std::size_t end : ends) {
    std::vector<std::size_t>& members = cells[cellOf(end)];
    if (!members.empty()) parent_[root(end)] = root(members.front());
    // Ends at the very same place say nothing new.
    if (members.empty() || ends_[members.back()] != ends_[end]) members.push_back(end);
  }
  for (const auto& [place, members] : cells) {
    for (long x = place.first; x <= place.first + kReach; ++x) {
      for (long y = place.second - kReach; y <= place.second + kReach; ++y) {
        const auto other = cells.find({x, y});
        if (other == cells.end() || std::make_pair(x, y) <= place) continue;
        const bool close = std::any_of(members.begin(), members.end(), [&](std::size_t a) {
          return std::any_of(other->second.begin(), other->second.end(), [&](std::size_t b) {
            return (ends_[a] - ends_[b]).norm() <= tolerance;
          });
        });
        if (close) parent_[root(other->second.front())] = root(members.front());
      }
    }
  }
}

std::size_t Joints::root(std::size_t end) {
  while (parent_[end] != end) {
    parent_[end] = parent_[parent_[end]];
    end = parent_[end];
  }
  return end;
}

void Joints::collect() {
  members_.assign(ends_.size(), {});
  for (std::size_t end = 0; end < ends_.size(); ++end) {
    parent_[end] = root(end);
    members_[parent_[end]].push_back(end);
  }
}

std::vector<Contour> chainClosed(const std::vector<Stroke>& strokes, double tolerance) {
  const Joints joints(strokes, tolerance);
  for (std::size_t end = 0; end < joints.count(); ++end) {
    if (joints.isLoose(end)) throwOpen(strokes, joints, end);
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
