// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/drawing_lines.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <stdexcept>

namespace planar_bin_picking::cell {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMetres = 1e-3;  // per unit of a drawing

/// One entity: its group codes, each with its values in order.
struct Entity {
  std::string kind;
  std::map<int, std::vector<std::string>> codes;

  std::size_t count(int code) const {
    const auto found = codes.find(code);
    return found == codes.end() ? 0 : found->second.size();
  }
  std::string text(int code) const { return count(code) == 0 ? "" : codes.at(code)[0]; }
  double number(int code, std::size_t i = 0, double otherwise = 0.0) const {
    return i < count(code) ? std::stod(codes.at(code)[i]) : otherwise;
  }
  double radians(int code) const { return number(code) * kPi / 180.0; }
  Eigen::Vector2d point(int code, std::size_t i = 0) const {
    return kMetres * Eigen::Vector2d(number(code, i), number(code + 10, i));
  }
};

struct Block {
  Eigen::Vector2d base = Eigen::Vector2d::Zero();
  std::vector<Entity> entities;
};

struct Drawn {
  std::vector<Entity> entities;
  std::map<std::string, Block> blocks;
};

std::string trimmed(std::string line) {
  while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.pop_back();
  const auto start = line.find_first_not_of(" \t");
  return start == std::string::npos ? "" : line.substr(start);
}

/// The entities of all sections, one after the other; SECTION and BLOCK are entities here, too.
std::vector<Entity> readGroups(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot be read");
  std::vector<Entity> entities;
  std::string code, value;
  while (std::getline(file, code) && std::getline(file, value)) {
    const int number = std::stoi(code);
    value = trimmed(value);
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

Drawn readDrawing(const std::string& path) {
  Drawn drawn;
  std::string section;
  Block* block = nullptr;
  for (Entity& entity : readGroups(path)) {
    if (entity.kind == "SECTION") section = entity.text(2);
    if (entity.kind == "SECTION" || entity.kind == "ENDSEC" || entity.kind == "EOF") continue;
    if (section == "ENTITIES") drawn.entities.push_back(std::move(entity));
    if (section != "BLOCKS") continue;
    if (entity.kind == "BLOCK") {
      block = &drawn.blocks[entity.text(2)];
      block->base = entity.point(10);
    } else if (entity.kind == "ENDBLK") {
      block = nullptr;
    } else if (block != nullptr) {
      block->entities.push_back(std::move(entity));
    }
  }
  return drawn;
}

bool startsWith(const std::string& word, const char* start) { return word.rfind(start, 0) == 0; }

bool isAnnotation(const std::string& layer) {
  return startsWith(layer, "DIM") || startsWith(layer, "CENTER") || startsWith(layer, "TITLE");
}

bool isNoLine(const std::string& kind) {
  for (const char* other :
       {"TEXT", "MTEXT", "ATTDEF", "ATTRIB", "SEQEND", "DIMENSION", "LEADER", "HATCH", "POINT"})
    if (kind == other) return true;
  return false;
}

bool isPrint(const std::string& layer) {
  return startsWith(layer, "PRINT") || startsWith(layer, "SILK") || startsWith(layer, "ENGRAVE");
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

/// A point of a rational B-spline, by de Boor's algorithm in homogeneous coordinates.
Eigen::Vector2d splinePoint(const std::vector<Eigen::Vector3d>& controls,
                            const std::vector<double>& knots, std::size_t degree, double t) {
  const auto above = std::upper_bound(knots.begin() + static_cast<std::ptrdiff_t>(degree),
                                      knots.end() - static_cast<std::ptrdiff_t>(degree) - 1, t);
  const auto k = std::min(static_cast<std::size_t>(above - knots.begin()) - 1, controls.size() - 1);
  std::vector<Eigen::Vector3d> d(controls.begin() + static_cast<std::ptrdiff_t>(k - degree),
                                 controls.begin() + static_cast<std::ptrdiff_t>(k + 1));
  for (std::size_t r = 1; r <= degree; ++r) {
    for (std::size_t j = degree; j >= r; --j) {
      const double low = knots[j + k - degree], high = knots[j + 1 + k - r];
      const double a = high > low ? (t - low) / (high - low) : 0.0;
      d[j] = (1.0 - a) * d[j - 1] + a * d[j];
    }
  }
  return d[degree].hnormalized();
}

Polygon spline(const Entity& entity, double chord) {
  constexpr int kMostPieces = 4096;
  const std::size_t degree = static_cast<std::size_t>(entity.number(71));
  std::vector<Eigen::Vector3d> controls;
  for (std::size_t i = 0; i < entity.count(10); ++i)
    controls.push_back(entity.number(41, i, 1.0) * entity.point(10, i).homogeneous());
  std::vector<double> knots;
  for (std::size_t i = 0; i < entity.count(40); ++i) knots.push_back(entity.number(40, i));
  if (degree < 1 || controls.size() <= degree || knots.size() != controls.size() + degree + 1)
    throw std::runtime_error("has a SPLINE whose knots do not fit its control points");
  const double from = knots[degree], to = knots[controls.size()];
  Polygon line;
  double worst = 2.0 * chord;
  for (int pieces = 32; worst > chord && pieces <= kMostPieces; pieces *= 2) {
    line.clear();
    worst = 0.0;
    for (int i = 0; i <= pieces; ++i) {
      const auto at = [&](double step) {
        return splinePoint(controls, knots, degree, from + (to - from) * step / pieces);
      };
      line.push_back(at(i));
      if (i > 0)
        worst = std::max(worst, (at(i - 0.5) - 0.5 * (line[line.size() - 2] + line.back())).norm());
    }
  }
  return line;
}

Polygon lineOf(const Entity& entity, double chord) {
  if (entity.kind == "LINE") return {entity.point(10), entity.point(11)};
  if (entity.kind == "LWPOLYLINE") return polyline(entity, chord);
  if (entity.kind == "SPLINE") return spline(entity, chord);
  const Eigen::Vector2d c = entity.point(10);
  const double r = kMetres * entity.number(40);
  if (entity.kind == "CIRCLE") return arc(c, {r, 0.0}, {0.0, r}, 0.0, 2.0 * kPi, chord);
  if (entity.kind == "ARC") {
    const double from = entity.radians(50);
    double to = entity.radians(51);
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

/// Where a list of entities stands in the drawing.
struct Placement {
  Eigen::Affine2d T_drawing_block = Eigen::Affine2d::Identity();
  std::string layer;  ///< of what stands on layer 0 in a block
  int depth = 0;
};

class Expander {
 public:
  Expander(const Drawn& drawn, double chord) : drawn_(drawn), chord_(chord) {}

  DrawnLines expand() {
    add(drawn_.entities, {});
    return std::move(lines_);
  }

 private:
  void add(const std::vector<Entity>& entities, const Placement& placement) {
    for (const Entity& entity : entities) {
      const bool inherits = placement.depth > 0 && entity.text(8) == "0";
      const std::string layer = inherits ? placement.layer : entity.text(8);
      if (isAnnotation(layer) || isNoLine(entity.kind)) continue;
      if (entity.kind == "INSERT") {
        addBlock(entity, placement, layer);
        continue;
      }
      const Eigen::Matrix2d& scale = placement.T_drawing_block.linear();
      Polygon line = lineOf(entity, chord_ / std::max(1.0, scale.colwise().norm().maxCoeff()));
      for (Eigen::Vector2d& p : line) p = placement.T_drawing_block * p;
      (isPrint(layer) ? lines_.prints : lines_.edges).push_back(std::move(line));
    }
  }

  void addBlock(const Entity& insert, const Placement& placement, const std::string& layer) {
    constexpr int kDeepest = 16;
    const auto block = drawn_.blocks.find(insert.text(2));
    if (block == drawn_.blocks.end())
      throw std::runtime_error("inserts the block " + insert.text(2) + ", which it does not have");
    if (placement.depth >= kDeepest) throw std::runtime_error("has blocks that hold themselves");
    if (insert.number(70, 0, 1.0) > 1.0 || insert.number(71, 0, 1.0) > 1.0)
      throw std::runtime_error("inserts a block in rows, which the simulated cell does not read");
    Placement inner{placement.T_drawing_block, layer, placement.depth + 1};
    inner.T_drawing_block.translate(insert.point(10));
    inner.T_drawing_block.rotate(insert.radians(50));
    inner.T_drawing_block.scale(
        Eigen::Vector2d(insert.number(41, 0, 1.0), insert.number(42, 0, 1.0)));
    inner.T_drawing_block.translate(-block->second.base);
    add(block->second.entities, inner);
  }

  const Drawn& drawn_;
  double chord_;
  DrawnLines lines_;
};

}  // namespace

DrawnLines readLines(const std::string& path, double chord) {
  const Drawn drawn = readDrawing(path);
  return Expander(drawn, chord).expand();
}

}  // namespace planar_bin_picking::cell
