// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/strokes.h"

#include "base/box_tree.h"
#include "base/polygon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace planar_bin_picking {
namespace {

/// Of a stroke's length: one line that is drawn twice lies nearer than this. A neighbour as short
/// as the tolerance is another line.
constexpr double kSameShare = 0.2;
/// Times what counts as near: so far behind its end a stroke is probed, so that a rib, which ends
/// on another line, does not seem to run along it.
constexpr double kBehind = 5.0;

using Points = std::vector<Eigen::Vector2d>;

double lengthOf(const Points& points) {
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

Eigen::AlignedBox2d boxOf(const Points& points) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : points) box.extend(p);
  return box;
}

Eigen::AlignedBox2d boxOf(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {a.cwiseMin(b), a.cwiseMax(b)};
}

Eigen::AlignedBox2d around(const Eigen::AlignedBox2d& box, double margin) {
  return {Eigen::Vector2d(box.min().array() - margin), Eigen::Vector2d(box.max().array() + margin)};
}

/// The chords of one polyline, to ask which are near a point.
class Chords {
 public:
  explicit Chords(const Points& points) : points_(points), tree_(boxesOf(points)) {}

  bool isNear(const Eigen::Vector2d& p, double tolerance) const {
    return tree_.any(around(boxOf(p, p), tolerance), [&](std::size_t i) {
      return distanceToSegment(p, points_[i], points_[i + 1]) <= tolerance;
    });
  }
  bool areNear(const Points& points, double tolerance) const {
    return std::all_of(points.begin(), points.end(),
                       [&](const Eigen::Vector2d& p) { return isNear(p, tolerance); });
  }

 private:
  static std::vector<Eigen::AlignedBox2d> boxesOf(const Points& points) {
    std::vector<Eigen::AlignedBox2d> boxes;
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      boxes.push_back(boxOf(points[i], points[i + 1]));
    return boxes;
  }
  const Points& points_;
  BoxTree tree_;
};

/// Two strokes are one line drawn twice if they are closer than this. A neighbour as short as the
/// tolerance must not pass for the same line.
double sameLine(const Points& points, double tolerance) {
  return std::min(tolerance, kSameShare * lengthOf(points));
}

/// Whether two strokes cover the same points: ends alone do not tell an arc from its chord.
bool coverTheSame(const Points& s, const Points& t, double tolerance) {
  const Eigen::AlignedBox2d a = boxOf(s), b = boxOf(t);
  return (a.min() - b.min()).norm() <= tolerance && (a.max() - b.max()).norm() <= tolerance &&
         Chords(t).areNear(s, tolerance) && Chords(s).areNear(t, tolerance);
}

void dropPoints(CleanStrokes* clean) {
  std::vector<Stroke> lines;
  for (Stroke& stroke : clean->strokes) {
    if (lengthOf(stroke.points) > kExactMm) lines.push_back(std::move(stroke));
  }
  clean->slivers += clean->strokes.size() - lines.size();
  clean->strokes = std::move(lines);
}

/// Drops strokes shorter than the tolerance that no contour runs through.
void dropSlivers(double tolerance, CleanStrokes* clean) {
  std::vector<Stroke>& lines = clean->strokes;
  std::vector<Stroke> kept;
  const Joints joints(lines, kExactMm);
  const std::size_t before = lines.size();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto &first = joints.meeting(2 * i), &last = joints.meeting(2 * i + 1);
    const bool through = first.size() == 2 && last.size() == 2 && first != last;
    if (through || lengthOf(lines[i].points) > tolerance) kept.push_back(std::move(lines[i]));
  }
  clean->slivers += before - kept.size();
  clean->strokes = std::move(kept);
}

void dropDuplicates(double tolerance, CleanStrokes* clean) {
  const std::vector<Stroke>& strokes = clean->strokes;
  // The corners of a stroke's box say which others may be the same; a grid over these four numbers
  // finds them without comparing all that share one of them.
  using Key = std::array<long, 4>;
  const auto keyOf = [&](const Points& points) {
    const Eigen::AlignedBox2d box = boxOf(points);
    const auto cell = [&](double x) {
      return static_cast<long>(std::floor(x / (2.0 * tolerance)));
    };
    return Key{cell(box.min().x()), cell(box.min().y()), cell(box.max().x()), cell(box.max().y())};
  };
  std::map<Key, std::vector<std::size_t>> cells;
  std::vector<Stroke> kept;
  const auto isThere = [&](const Stroke& stroke, const Key& key) {
    const auto cell = cells.find(key);
    if (cell == cells.end()) return false;
    const double near = sameLine(stroke.points, tolerance);
    return std::any_of(cell->second.begin(), cell->second.end(), [&](std::size_t other) {
      return coverTheSame(stroke.points, kept[other].points, near);
    });
  };
  for (const Stroke& stroke : strokes) {
    // Each number may fall into the cell beside: the nearer one, since cells are twice as wide.
    const Eigen::AlignedBox2d box = boxOf(stroke.points);
    const Key low = keyOf({Eigen::Vector2d(box.min().array() - tolerance),
                           Eigen::Vector2d(box.max().array() - tolerance)});
    bool twice = false;
    for (int corner = 0; corner < 16 && !twice; ++corner) {
      Key key = low;
      for (int k = 0; k < 4; ++k) key[static_cast<std::size_t>(k)] += corner >> k & 1;
      twice = isThere(stroke, key);
    }
    if (twice) {
      ++clean->twice;
      continue;
    }
    cells[keyOf(stroke.points)].push_back(kept.size());
    kept.push_back(stroke);
  }
  clean->strokes = std::move(kept);
}

/// A place on a polyline: on the chord with this number, a share of it along.
using Place = std::pair<std::size_t, double>;

/// All chords of all strokes.
class AllChords {
 public:
  explicit AllChords(const std::vector<Stroke>& strokes) : strokes_(strokes), tree_(collect()) {}

  /// Calls visit(stroke, place) for each stroke's chord that passes a point, with the foot on it.
  template <class Visit>
  void passing(const Eigen::Vector2d& p, double tolerance, const Visit& visit) const {
    tree_.any(around(boxOf(p, p), tolerance), [&](std::size_t k) {
      const auto [stroke, chord] = owners_[k];
      const Eigen::Vector2d &a = strokes_[stroke].points[chord],
                            &b = strokes_[stroke].points[chord + 1];
      if (distanceToSegment(p, a, b) > tolerance) return false;
      const double share = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
      visit(stroke, Place(chord, share));
      return false;
    });
  }

 private:
  std::vector<Eigen::AlignedBox2d> collect() {
    std::vector<Eigen::AlignedBox2d> boxes;
    for (std::size_t i = 0; i < strokes_.size(); ++i) {
      const Points& points = strokes_[i].points;
      for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        if (points[k] == points[k + 1]) continue;
        boxes.push_back(boxOf(points[k], points[k + 1]));
        owners_.emplace_back(i, k);
      }
    }
    return boxes;
  }

  const std::vector<Stroke>& strokes_;
  std::vector<std::pair<std::size_t, std::size_t>> owners_;
  BoxTree tree_;
};

/// A point of the stroke a bit behind its first point (or before its last): which way it leaves.
Eigen::Vector2d behindEnd(const Points& points, bool last, double distance) {
  double left = distance;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const std::size_t k = last ? points.size() - 1 - i : i, next = last ? k - 1 : k + 1;
    const double length = (points[next] - points[k]).norm();
    if (length >= left) return points[k] + left / length * (points[next] - points[k]);
    left -= length;
  }
  return last ? points.front() : points.back();
}

Eigen::Vector2d pointAt(const Points& points, const Place& place) {
  return points[place.first] + place.second * (points[place.first + 1] - points[place.first]);
}

/// Where each stroke has to be cut, because another that ends there runs along it.
std::vector<std::map<Place, Eigen::Vector2d>> findCuts(const std::vector<Stroke>& strokes,
                                                       double tolerance) {
  const AllChords chords(strokes);
  std::vector<std::map<Place, Eigen::Vector2d>> cuts(strokes.size());
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    const Points& own = strokes[i].points;
    const double near = sameLine(own, tolerance);
    for (const bool last : {false, true}) {
      if (strokes[i].closed) continue;
      const Eigen::Vector2d end = last ? own.back() : own.front();
      const Eigen::Vector2d probe = behindEnd(own, last, std::min(kBehind * near, lengthOf(own)));
      chords.passing(end, near, [&](std::size_t other, const Place& place) {
        if (other == i) return;
        const Points& points = strokes[other].points;
        const Eigen::Vector2d foot = pointAt(points, place);
        const bool at_its_end =
            !strokes[other].closed &&
            std::min((foot - points.front()).norm(), (foot - points.back()).norm()) <= tolerance;
        if (at_its_end) return;
        bool along = false;
        chords.passing(probe, near,
                       [&](std::size_t same, const Place&) { along |= same == other; });
        if (along) cuts[other].emplace(place, end);
      });
    }
  }
  return cuts;
}

/// The pieces of a stroke between its cuts.
std::vector<Stroke> cutStroke(const Stroke& stroke, const std::map<Place, Eigen::Vector2d>& cuts) {
  std::vector<Points> pieces(1);
  std::size_t chord = 0;
  pieces.back().push_back(stroke.points.front());
  for (const auto& [place, end] : cuts) {
    for (; chord < place.first; ++chord) pieces.back().push_back(stroke.points[chord + 1]);
    // Two ends that meet here make one cut.
    if (pieces.size() > 1 && (pieces.back().front() - end).norm() <= kExactMm) continue;
    pieces.back().push_back(end);
    pieces.push_back({end});
  }
  for (; chord + 1 < stroke.points.size(); ++chord)
    pieces.back().push_back(stroke.points[chord + 1]);
  if (stroke.closed) {  // its seam is no end
    Points first = std::move(pieces.front());
    pieces.erase(pieces.begin());
    pieces.back().insert(pieces.back().end(), first.begin() + 1, first.end());
  }
  std::vector<Stroke> strokes;
  for (Points& points : pieces) {
    if (lengthOf(points) <= kExactMm) continue;
    Stroke piece = stroke;
    piece.closed = false;
    piece.points = std::move(points);
    strokes.push_back(std::move(piece));
  }
  return strokes;
}

void cutOverlaps(double tolerance, CleanStrokes* clean) {
  const auto cuts = findCuts(clean->strokes, tolerance);
  if (std::all_of(cuts.begin(), cuts.end(), [](const auto& c) { return c.empty(); })) return;
  std::vector<Stroke> pieces;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    if (cuts[i].empty()) {
      pieces.push_back(std::move(clean->strokes[i]));
    } else {
      for (Stroke& piece : cutStroke(clean->strokes[i], cuts[i]))
        pieces.push_back(std::move(piece));
    }
  }
  clean->strokes = std::move(pieces);
  dropDuplicates(tolerance, clean);
  dropSlivers(tolerance, clean);
}

}  // namespace

CleanStrokes cleanStrokes(const std::vector<Stroke>& strokes, double tolerance) {
  CleanStrokes clean{strokes, 0, 0};
  dropPoints(&clean);
  dropDuplicates(tolerance, &clean);
  dropSlivers(tolerance, &clean);
  cutOverlaps(tolerance, &clean);
  return clean;
}

}  // namespace planar_bin_picking
