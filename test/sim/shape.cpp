// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/shape.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <stdexcept>

namespace planar_bin_picking::cell {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMetres = 1e-3;  // per unit of a drawing
constexpr double kJoin = 2e-5;    // metres; ends this near meet

/// One entity: its group codes, each with its values in order.
struct Entity {
  std::string kind;
  std::map<int, std::vector<std::string>> codes;

  double number(int code, std::size_t i = 0, double otherwise = 0.0) const {
    const auto found = codes.find(code);
    return found == codes.end() || found->second.size() <= i ? otherwise
                                                             : std::stod(found->second[i]);
  }
  Eigen::Vector2d point(int code, std::size_t i = 0) const {
    return kMetres * Eigen::Vector2d(number(code, i), number(code + 10, i));
  }
};

std::string trimmed(std::string line) {
  while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.pop_back();
  const auto start = line.find_first_not_of(" \t");
  return start == std::string::npos ? "" : line.substr(start);
}

std::vector<Entity> readEntities(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::vector<Entity> entities;
  std::string code, value, section;
  bool names_section = false;
  while (std::getline(file, code) && std::getline(file, value)) {
    const int number = std::stoi(code);
    value = trimmed(value);
    if (names_section && number == 2) section = value;
    names_section = number == 0 && value == "SECTION";
    if (section != "ENTITIES") continue;
    if (number == 0) entities.push_back({value, {}});
    if (entities.empty()) continue;
    auto& codes = entities.back().codes;
    // A bulge belongs to the point before it, and points without one are straight.
    if (number == 42 && entities.back().kind == "LWPOLYLINE")
      codes[42].resize(codes[10].size() - 1, "0");
    codes[number].push_back(value);
  }
  return entities;
}

bool isEdge(const Entity& entity) {
  const auto found = entity.codes.find(8);
  if (found == entity.codes.end()) return false;
  for (const char* layer : {"DIM", "CENTER", "TITLE", "PRINT"})
    if (found->second[0] == layer) return false;
  return true;
}

/// A piece of an ellipse about c with half axes u and v, from parameter a to b.
Polygon arc(const Eigen::Vector2d& c, const Eigen::Vector2d& u, const Eigen::Vector2d& v, double a,
            double b, double chord) {
  const double radius = std::max(u.norm(), v.norm());
  const double step = 2.0 * std::acos(1.0 - std::min(0.5, chord / radius));
  const int pieces = std::max(2, static_cast<int>(std::ceil(std::abs(b - a) / step)));
  Polygon line;
  for (int i = 0; i <= pieces; ++i) {
    const double t = a + (b - a) * i / pieces;
    line.push_back(c + std::cos(t) * u + std::sin(t) * v);
  }
  return line;
}

/// From p to q along the arc whose bulge is the tangent of a quarter of its angle.
void addBulge(const Eigen::Vector2d& p, const Eigen::Vector2d& q, double bulge, double chord,
              Polygon* line) {
  if (bulge == 0.0) return;
  const Eigen::Vector2d d = q - p, normal(-d.y(), d.x());
  const Eigen::Vector2d c = 0.5 * (p + q) + normal * (1.0 - bulge * bulge) / (4.0 * bulge);
  const Eigen::Vector2d u = p - c, v(-u.y(), u.x());
  const Polygon points = arc(c, u, v, 0.0, 4.0 * std::atan(bulge), chord);
  line->insert(line->end(), points.begin() + 1, points.end() - 1);
}

Polygon polyline(const Entity& entity, double chord) {
  const std::size_t count = entity.codes.at(10).size();
  const bool closed = static_cast<int>(entity.number(70)) & 1;
  Polygon line;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d p = entity.point(10, i), q = entity.point(10, (i + 1) % count);
    line.push_back(p);
    if (closed || i + 1 < count) addBulge(p, q, entity.number(42, i), chord, &line);
  }
  if (closed) line.push_back(line.front());
  return line;
}

Polygon lineOf(const Entity& entity, double chord) {
  const auto radians = [&](int code) { return entity.number(code) * kPi / 180.0; };
  if (entity.kind == "LINE") return {entity.point(10), entity.point(11)};
  if (entity.kind == "LWPOLYLINE") return polyline(entity, chord);
  const Eigen::Vector2d c = entity.point(10);
  const double r = kMetres * entity.number(40);
  if (entity.kind == "CIRCLE") return arc(c, {r, 0.0}, {0.0, r}, 0.0, 2.0 * kPi, chord);
  if (entity.kind == "ARC") {
    const double from = radians(50);
    double to = radians(51);
    while (to <= from) to += 2.0 * kPi;
    return arc(c, {r, 0.0}, {0.0, r}, from, to, chord);
  }
  if (entity.kind == "ELLIPSE") {
    const Eigen::Vector2d u = entity.point(11),
                          v = entity.number(40) * Eigen::Vector2d(-u.y(), u.x());
    return arc(c, u, v, entity.number(41), entity.number(42), chord);
  }
  throw std::runtime_error("has a " + entity.kind + ", which the simulated cell does not read");
}

bool meet(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - b).norm() < kJoin; }

/// Joins lines at their ends to rings.
std::vector<Polygon> joinRings(std::vector<Polygon> lines) {
  std::vector<Polygon> rings;
  while (!lines.empty()) {
    Polygon ring = lines.back();
    lines.pop_back();
    while (!meet(ring.front(), ring.back())) {
      const auto next = std::find_if(lines.begin(), lines.end(), [&](const Polygon& line) {
        return meet(line.front(), ring.back()) || meet(line.back(), ring.back());
      });
      if (next == lines.end()) throw std::runtime_error("has a contour that is not closed");
      if (!meet(next->front(), ring.back())) std::reverse(next->begin(), next->end());
      ring.insert(ring.end(), next->begin() + 1, next->end());
      lines.erase(next);
    }
    ring.pop_back();
    rings.push_back(ring);
  }
  return rings;
}

bool inside(const Polygon& ring, const Eigen::Vector2d& p) {
  bool in = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const auto &a = ring[i], &b = ring[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()))
      in = !in;
  }
  return in;
}

double distanceToSides(const Polygon& ring, const Eigen::Vector2d& p) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i], d = ring[(i + 1) % ring.size()] - a;
    const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-18), 0.0, 1.0);
    best = std::min(best, (a + t * d - p).norm());
  }
  return best;
}

double distanceToOutline(const Shape& shape, const Eigen::Vector2d& p) {
  double best = distanceToSides(shape.outer, p);
  for (const Polygon& hole : shape.holes) best = std::min(best, distanceToSides(hole, p));
  return best;
}

Eigen::Vector2d centroid(const Polygon& ring) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i], b = ring[(i + 1) % ring.size()];
    sum += (a + b) * (a.x() * b.y() - b.x() * a.y());
  }
  return sum / (6.0 * area(ring));
}

/// Some corners of all rings, and their image under a map, against the outline.
bool liesOnItself(const Shape& shape, const Eigen::Matrix2d& turn, const Eigen::Vector2d& center,
                  double tolerance) {
  const auto fits = [&](const Polygon& ring) {
    return std::all_of(ring.begin(), ring.end(), [&](const Eigen::Vector2d& p) {
      return distanceToOutline(shape, center + turn * (p - center)) <= tolerance;
    });
  };
  return fits(shape.outer) && std::all_of(shape.holes.begin(), shape.holes.end(), fits);
}

Eigen::Isometry3d about(const Eigen::Vector2d& center, double z, const Eigen::Matrix3d& R) {
  const Eigen::Vector3d c(center.x(), center.y(), z);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = c - R * c;
  return T;
}

}  // namespace

Shape loadShape(const std::string& path, double thickness, double chord) {
  try {
    std::vector<Polygon> lines;
    for (const Entity& entity : readEntities(path))
      if (isEdge(entity)) lines.push_back(lineOf(entity, chord));
    std::vector<Polygon> rings = joinRings(lines);
    if (rings.empty()) throw std::runtime_error("has no edge");
    std::sort(rings.begin(), rings.end(), [](const Polygon& a, const Polygon& b) {
      return std::abs(area(a)) > std::abs(area(b));
    });
    for (std::size_t i = 0; i < rings.size(); ++i)
      if ((area(rings[i]) > 0.0) != (i == 0)) std::reverse(rings[i].begin(), rings[i].end());
    return {rings[0], {rings.begin() + 1, rings.end()}, thickness};
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

double area(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5 * twice;
}

double area(const Shape& shape) {
  double sum = area(shape.outer);
  for (const Polygon& hole : shape.holes) sum += area(hole);  // clockwise: negative
  return sum;
}

bool contains(const Shape& shape, const Eigen::Vector2d& point) {
  return inside(shape.outer, point) &&
         std::none_of(shape.holes.begin(), shape.holes.end(),
                      [&](const Polygon& hole) { return inside(hole, point); });
}

std::vector<Eigen::Isometry3d> symmetries(const Shape& shape, double tolerance) {
  constexpr int kSteps = 720;  // half degrees, for mirror axes
  constexpr int kMostTurns = 36;
  const Eigen::Vector2d center = centroid(shape.outer);
  std::vector<Eigen::Isometry3d> found = {Eigen::Isometry3d::Identity()};
  const auto rotation = [](double a) { return Eigen::Rotation2Dd(a).toRotationMatrix(); };
  int order = 1;
  for (int k = 2; k <= 2 * kMostTurns; ++k)
    if (liesOnItself(shape, rotation(2.0 * kPi / k), center, tolerance)) order = k;
  for (int i = 1; i < order; ++i) {
    found.push_back(about(
        center, 0.0,
        Eigen::AngleAxisd(2.0 * kPi * i / order, Eigen::Vector3d::UnitZ()).toRotationMatrix()));
  }
  // A turn by half a circle about an axis in the middle plane mirrors the outline.
  for (int i = 0; i < kSteps; ++i) {
    const double axis = kPi * i / kSteps;
    const Eigen::Matrix2d mirror =
        rotation(axis) * Eigen::Vector2d(1.0, -1.0).asDiagonal() * rotation(-axis);
    if (!liesOnItself(shape, mirror, center, tolerance)) continue;
    const Eigen::Vector3d direction(std::cos(axis), std::sin(axis), 0.0);
    const Eigen::Isometry3d flip =
        about(center, -0.5 * shape.thickness, Eigen::AngleAxisd(kPi, direction).toRotationMatrix());
    const std::size_t turns = found.size();
    for (std::size_t k = 0; k < turns; ++k) found.push_back(found[k] * flip);
    break;
  }
  return found;
}

}  // namespace planar_bin_picking::cell
