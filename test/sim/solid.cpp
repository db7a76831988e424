// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/solid.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking::cell {
namespace {

/// Between two vertical lines: from `left` to `right` below, and back above.
struct Trapezoid {
  Eigen::Vector2d below_left, below_right, above_left, above_right;
};

/// Cuts the shape by vertical lines through all its corners: what lies between two of them has
/// straight sides and no corner inside, hence is convex.
std::vector<Trapezoid> slice(const Shape& shape) {
  constexpr double kThinnest = 1e-7;  // metres
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> sides;
  std::vector<double> cuts;
  const auto add = [&](const Polygon& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d a = ring[i], b = ring[(i + 1) % ring.size()];
      cuts.push_back(a.x());
      if (a.x() < b.x()) sides.emplace_back(a, b);
      if (b.x() < a.x()) sides.emplace_back(b, a);
    }
  };
  add(shape.outer);
  for (const Polygon& hole : shape.holes) add(hole);
  std::sort(cuts.begin(), cuts.end());
  std::vector<Trapezoid> pieces;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double x0 = cuts[i], x1 = cuts[i + 1], middle = 0.5 * (x0 + x1);
    if (x1 - x0 < kThinnest) continue;
    const auto height = [](const auto& side, double x) {
      const Eigen::Vector2d d = side.second - side.first;
      return side.first.y() + d.y() * (x - side.first.x()) / d.x();
    };
    std::vector<std::pair<double, std::size_t>> crossings;
    for (std::size_t k = 0; k < sides.size(); ++k)
      if (sides[k].first.x() < middle && middle < sides[k].second.x())
        crossings.emplace_back(height(sides[k], middle), k);
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
      const auto &low = sides[crossings[k].second], &high = sides[crossings[k + 1].second];
      pieces.push_back({{x0, height(low, x0)},
                        {x1, height(low, x1)},
                        {x0, height(high, x0)},
                        {x1, height(high, x1)}});
    }
  }
  return pieces;
}

/// The ring moved into the material by a distance, corner by corner.
Polygon inset(const Polygon& ring, double distance) {
  Polygon moved;
  const std::size_t n = ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d in = (ring[i] - ring[(i + n - 1) % n]).normalized(),
                          out = (ring[(i + 1) % n] - ring[i]).normalized();
    const Eigen::Vector2d a(-in.y(), in.x()), b(-out.y(), out.x());  // to the left: material
    const Eigen::Vector2d sum = a + b;
    moved.push_back(ring[i] + distance * 2.0 * sum / std::max(1.0, sum.squaredNorm()));
  }
  return moved;
}

void addTriangle(const std::array<Eigen::Vector3d, 3>& corners, Mesh* mesh) {
  const auto first = static_cast<unsigned>(mesh->points.size());
  for (const auto& corner : corners) mesh->points.push_back(corner.cast<float>());
  mesh->faces.push_back({first, first + 1, first + 2});
}

Eigen::Vector3d at(const Eigen::Vector2d& p, double z) { return {p.x(), p.y(), z}; }

/// A face at height z; `up` says to which side it looks.
void addFace(const Shape& shape, double z, bool up, Mesh* mesh) {
  for (const Trapezoid& t : slice(shape)) {
    std::array<Eigen::Vector3d, 4> c = {at(t.below_left, z), at(t.below_right, z),
                                        at(t.above_right, z), at(t.above_left, z)};
    if (!up) std::reverse(c.begin(), c.end());
    addTriangle({c[0], c[1], c[2]}, mesh);
    addTriangle({c[0], c[2], c[3]}, mesh);
  }
}

/// The band between a ring at one height and a ring at a lower one.
void addBand(const Polygon& high, double z_high, const Polygon& low, double z_low, Mesh* mesh) {
  for (std::size_t i = 0; i < high.size(); ++i) {
    const std::size_t k = (i + 1) % high.size();
    const Eigen::Vector3d a = at(low[i], z_low), b = at(low[k], z_low), c = at(high[k], z_high),
                          d = at(high[i], z_high);
    addTriangle({a, b, c}, mesh);
    addTriangle({a, c, d}, mesh);
  }
}

double cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

Polygon hull(Polygon points) {
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  Polygon ring;
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = ring.size();
    for (const auto& p : points) {
      while (ring.size() >= start + 2 && cross(ring[ring.size() - 2], ring.back(), p) <= 1e-14)
        ring.pop_back();
      ring.push_back(p);
    }
    ring.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return ring;
}

Eigen::AlignedBox2d boxOf(const Polygon& ring) {
  Eigen::AlignedBox2d box;
  for (const auto& p : ring) box.extend(p);
  return box;
}

bool touch(const Eigen::AlignedBox2d& a, const Eigen::AlignedBox2d& b) {
  constexpr double kNear = 1e-7;
  return a.exteriorDistance(b) < kNear;
}

}  // namespace

Mesh makeMesh(const Shape& shape, double bevel) {
  Shape small = shape;
  small.outer = inset(shape.outer, bevel);
  for (Polygon& hole : small.holes) hole = inset(hole, bevel);
  Mesh mesh;
  addFace(small, 0.0, true, &mesh);
  addFace(small, -shape.thickness, false, &mesh);
  const auto addWalls = [&](const Polygon& ring, const Polygon& moved) {
    addBand(moved, 0.0, ring, -bevel, &mesh);
    addBand(ring, -bevel, ring, bevel - shape.thickness, &mesh);
    addBand(ring, bevel - shape.thickness, moved, -shape.thickness, &mesh);
  };
  addWalls(shape.outer, small.outer);
  for (std::size_t i = 0; i < shape.holes.size(); ++i) addWalls(shape.holes[i], small.holes[i]);
  return mesh;
}

std::vector<Polygon> convexPieces(const Shape& shape, double slack) {
  struct Piece {
    Polygon ring;
    double area;
    Eigen::AlignedBox2d box;
  };
  std::vector<Piece> pieces;
  for (const Trapezoid& t : slice(shape)) {
    const Polygon ring = hull({t.below_left, t.below_right, t.above_left, t.above_right});
    if (ring.size() >= 3) pieces.push_back({ring, cell::area(ring), boxOf(ring)});
  }
  // The pair that wastes least is joined, again and again.
  for (;;) {
    double best = slack;
    std::size_t a = 0, b = 0;
    Piece joined;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      for (std::size_t k = i + 1; k < pieces.size(); ++k) {
        if (!touch(pieces[i].box, pieces[k].box)) continue;
        Polygon points = pieces[i].ring;
        points.insert(points.end(), pieces[k].ring.begin(), pieces[k].ring.end());
        const Polygon ring = hull(points);
        const double real = pieces[i].area + pieces[k].area, waste = cell::area(ring) - real;
        if (waste < best) best = waste, a = i, b = k, joined = {ring, real, boxOf(ring)};
      }
    }
    if (b == 0) break;
    pieces[a] = joined;
    pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(b));
  }
  std::vector<Polygon> rings;
  for (const Piece& piece : pieces) rings.push_back(piece.ring);
  return rings;
}

}  // namespace planar_bin_picking::cell
