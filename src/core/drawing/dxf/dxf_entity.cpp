// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/dxf_entity.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

DxfKind kindOf(std::string_view type) {
  static const std::map<std::string_view, DxfKind> kKinds = [] {
    std::map<std::string_view, DxfKind> kinds;
    for (const char* t : {"LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE"})
      kinds[t] = DxfKind::kCurve;
    for (const char* t : {"REGION", "BODY", "3DSOLID", "SURFACE", "PLANESURFACE", "EXTRUDEDSURFACE",
                          "REVOLVEDSURFACE", "SWEPTSURFACE", "LOFTEDSURFACE", "NURBSURFACE", "MESH",
                          "MLINE", "HELIX", "ACAD_PROXY_ENTITY", "3DFACE"})
      kinds[t] = DxfKind::kUnreadable;
    for (const char* t : {"TEXT", "MTEXT", "RTEXT", "ARCALIGNEDTEXT", "ATTDEF", "ATTRIB",
                          "DIMENSION", "ARC_DIMENSION", "LARGE_RADIAL_DIMENSION", "LEADER",
                          "MULTILEADER", "MLEADER", "TOLERANCE", "ACAD_TABLE"})
      kinds[t] = DxfKind::kText;
    for (const char* t : {"HATCH", "MPOLYGON", "SOLID", "TRACE", "WIPEOUT"})
      kinds[t] = DxfKind::kHatch;
    kinds["INSERT"] = DxfKind::kInsert;
    return kinds;
  }();
  const auto it = kKinds.find(type);
  return it == kKinds.end() ? DxfKind::kOther : it->second;
}

/// The plane of an entity, seen from above: where its x, y and height come to lie.
struct Plane {
  Eigen::Affine2d at_zero = Eigen::Affine2d::Identity();
  Eigen::Vector2d rise = Eigen::Vector2d::Zero();  ///< per height over the plane through the origin
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();

  Eigen::Affine2d at(double height) const { return Eigen::Translation2d(height * rise) * at_zero; }
};

/// The share by which a tilted plane looks shorter.
double tiltOf(const Plane& plane) { return 1.0 - std::abs(plane.normal.z()); }

/// Codes 210 to 230, by the DXF reference's "arbitrary axis algorithm".
Plane planeOf(const DxfRecord& record) {
  Plane plane;
  if (findGroup(record, 210) == nullptr && findGroup(record, 220) == nullptr &&
      findGroup(record, 230) == nullptr)
    return plane;
  const Eigen::Vector3d normal(realOf(record, 210, 0.0), realOf(record, 220, 0.0),
                               realOf(record, 230, 1.0));
  if (!(normal.stableNorm() > 0.0)) return plane;  // some programs write zeros for "none"
  plane.normal = normal.stableNormalized();
  constexpr double kNearZ = 1.0 / 64.0;
  const bool near_z = plane.normal.head<2>().cwiseAbs().maxCoeff() < kNearZ;
  const Eigen::Vector3d x = (near_z ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ())
                                .cross(plane.normal)
                                .normalized();
  const Eigen::Vector3d y = plane.normal.cross(x);
  plane.at_zero.matrix().topLeftCorner<2, 2>() << x.x(), y.x(), x.y(), y.y();
  plane.rise = plane.normal.head<2>();
  return plane;
}

Curve placed(Curve curve, const Eigen::Affine2d& placement) {
  if (curve.breaks.empty() || placement.matrix() == Eigen::Affine2d::Identity().matrix())
    return curve;
  for (Eigen::Vector2d& center : curve.centers) center = placement * center;
  curve.at = [at = std::move(curve.at), placement](double t) -> Eigen::Vector2d {
    return placement * at(t);
  };
  return curve;
}

Eigen::Vector2d pointOf(const DxfRecord& record, int code) {
  return {realOf(record, code, 0.0), realOf(record, code + 10, 0.0)};
}

Curve readArc(const DxfRecord& record, const Plane& plane, bool whole) {
  const double radius = realOf(record, 40, 0.0);
  if (!(radius > 0.0))
    throw std::runtime_error("has a radius that is not greater than 0; delete it");
  const double start = whole ? 0.0 : realOf(record, 50, 0.0);
  const double end = whole ? 360.0 : realOf(record, 51, 360.0);
  return placed(makeEllipse(pointOf(record, 10), {radius, 0.0}, {0.0, radius}, start * kDegree,
                            end * kDegree),
                plane.at(realOf(record, 30, 0.0)));
}

/// Center and axis are given in the drawing's space, not in the ellipse's plane.
Curve readEllipse(const DxfRecord& record, const Plane& plane) {
  constexpr double kTurn = 2.0 * 3.14159265358979323846;
  const Eigen::Vector3d major(realOf(record, 11, 0.0), realOf(record, 21, 0.0),
                              realOf(record, 31, 0.0));
  const double ratio = realOf(record, 40, 1.0);
  const double start = realOf(record, 41, 0.0), end = realOf(record, 42, kTurn);
  if (!(major.norm() > 0.0) || !(ratio > 0.0))
    throw std::runtime_error("has an axis without length; delete it");
  constexpr double kMostTurns = 100.0;  // an angle of more has lost its accuracy
  if (std::max(std::abs(start), std::abs(end)) > kMostTurns * kTurn)
    throw std::runtime_error("has angles that are none; the file is damaged");
  const Eigen::Vector3d minor = ratio * plane.normal.cross(major);
  return makeEllipse(pointOf(record, 10), major.head<2>(), minor.head<2>(), start, end);
}

void checkCount(const DxfRecord& record, int count_code, std::size_t items) {
  const DxfGroup* stated = findGroup(record, count_code);
  if (stated == nullptr) return;
  const std::string type(record.front().value);
  if (integerOf(*stated, type) == static_cast<int>(items)) return;
  refuseLine(stated->line, "this " + type + " states " + std::string(stated->value) +
                               " items and has " + std::to_string(items) +
                               "; the file is damaged, export it again");
}

Curve readLightPolyline(const DxfRecord& record, const Plane& plane) {
  std::vector<BulgeVertex> vertices;
  const std::string_view type = record.front().value;
  for (std::size_t i = 1; i < record.size(); ++i) {
    const DxfGroup& group = record[i];
    if (group.code == 10) {
      vertices.emplace_back();
      vertices.back().position = {realOf(group, type), 0.0};
    } else if (vertices.empty()) {
      continue;
    } else if (group.code == 20) {
      vertices.back().position.y() = realOf(group, type);
    } else if (group.code == 42) {
      vertices.back().bulge = realOf(group, type);
    }
  }
  checkCount(record, 90, vertices.size());
  const bool closed = (integerOf(record, 70, 0) & 1) != 0;
  return placed(makePolyline(std::move(vertices), closed), plane.at(realOf(record, 38, 0.0)));
}

Curve readSpline(const DxfRecord& record) {
  SplineData spline;
  const std::string_view type = record.front().value;
  spline.degree = integerOf(record, 71, 3);
  spline.closed = (integerOf(record, 70, 0) & 1) != 0;
  for (std::size_t i = 1; i < record.size(); ++i) {
    const DxfGroup& group = record[i];
    auto &control = spline.control_points, &fit = spline.fit_points;
    switch (group.code) {
      case 10:
        control.emplace_back(realOf(group, type), 0.0);
        break;
      case 20:
        if (!control.empty()) control.back().y() = realOf(group, type);
        break;
      case 11:
        fit.emplace_back(realOf(group, type), 0.0);
        break;
      case 21:
        if (!fit.empty()) fit.back().y() = realOf(group, type);
        break;
      case 40:
        spline.knots.push_back(realOf(group, type));
        break;
      case 41:
        spline.weights.push_back(realOf(group, type));
        break;
      default:
        break;
    }
  }
  if (spline.weights.empty()) spline.weights.assign(spline.control_points.size(), 1.0);
  spline.start_tangent = pointOf(record, 12);
  spline.end_tangent = pointOf(record, 13);
  checkCount(record, 72, spline.knots.size());
  checkCount(record, 73, spline.control_points.size());
  checkCount(record, 74, spline.fit_points.size());
  return makeSpline(spline);
}

DxfInsert readInsert(const DxfRecord& record, const Plane& plane, const DxfNames& names) {
  DxfInsert insert;
  insert.block = names.decode(textOf(record, 2, ""));
  insert.columns = std::max(1, integerOf(record, 70, 1));
  insert.rows = std::max(1, integerOf(record, 71, 1));
  const double x = realOf(record, 41, 1.0), y = realOf(record, 42, 1.0);
  if (x == 0.0 || y == 0.0) throw std::runtime_error("scales its block to nothing; delete it");
  const Eigen::Affine2d turned = plane.at(realOf(record, 30, 0.0)) *
                                 Eigen::Translation2d(pointOf(record, 10)) *
                                 Eigen::Rotation2Dd(realOf(record, 50, 0.0) * kDegree);
  insert.column = turned.linear() * Eigen::Vector2d(realOf(record, 44, 0.0), 0.0);
  insert.row = turned.linear() * Eigen::Vector2d(0.0, realOf(record, 45, 0.0));
  insert.placement = turned * Eigen::Scaling(x, y);
  return insert;
}

void readGeometry(const DxfRecord& record, const DxfNames& names, DxfEntity* entity) {
  const std::string& type = entity->type;
  if (type == "LINE") {
    entity->curve = makeLine(pointOf(record, 10), pointOf(record, 11));
    return;
  }
  const Plane plane = planeOf(record);
  entity->tilt = tiltOf(plane);
  if (type == "INSERT")
    entity->insert = std::make_shared<const DxfInsert>(readInsert(record, plane, names));
  if (type == "ARC" || type == "CIRCLE") entity->curve = readArc(record, plane, type == "CIRCLE");
  if (type == "ELLIPSE") entity->curve = readEllipse(record, plane);
  if (type == "LWPOLYLINE") entity->curve = readLightPolyline(record, plane);
  if (type == "SPLINE") entity->curve = readSpline(record);
}

/// The number that a dimension's text shows instead of what it measures; nothing where it shows no
/// single length.
std::optional<double> writtenNumber(std::string text) {
  if (text.find("<>") != std::string::npos || text.find_first_not_of(' ') == std::string::npos)
    return std::nullopt;
  for (const char* sign : {"%%c", "%%C", "\xc3\x98", "\xe2\x8c\x80", "R", "mm"}) {
    const std::size_t at = text.find(sign);
    if (at != std::string::npos) text.erase(at, std::string(sign).size());
  }
  const std::size_t first = text.find_first_not_of(' ');
  const std::size_t last = text.find_last_not_of(' ');
  if (first == std::string::npos) return std::nullopt;
  text = text.substr(first, last - first + 1);
  if (text.find_first_not_of("0123456789.,") != std::string::npos) return std::nullopt;
  return realOf(DxfGroup{1, text, 0}, "DIMENSION");
}

/// $DIMLFAC as an override: "DSTYLE" in the extended data holds pairs of a code and a value.
std::optional<double> overriddenFactor(const DxfRecord& record) {
  constexpr int kDimlfac = 144;
  for (std::size_t i = 1; i + 1 < record.size(); ++i) {
    if (record[i].code == 1070 && record[i].value == std::to_string(kDimlfac) &&
        record[i + 1].code == 1040)
      return realOf(record[i + 1], "DIMENSION");
  }
  return std::nullopt;
}

}  // namespace

DxfEntity readEntity(const DxfRecord& record, const DxfNames& names) {
  DxfEntity entity;
  entity.type = std::string(record.front().value);
  entity.kind = kindOf(entity.type);
  entity.layer = names.decode(textOf(record, 8, "0"));
  entity.linetype = names.decode(textOf(record, 6, "BYLAYER"));
  try {
    entity.invisible = integerOf(record, 60, 0) == 1;
    entity.on_paper = integerOf(record, 67, 0) == 1;
    readGeometry(record, names, &entity);
  } catch (const std::runtime_error& e) {
    entity.fault = e.what();
  }
  return entity;
}

void PolylineReader::begin(const DxfRecord& polyline, DxfEntity* entity) {
  vertices_.clear();
  if (!entity->fault.empty()) return;
  try {
    flags_ = integerOf(polyline, 70, 0);
    const Plane plane = planeOf(polyline);
    // A three-dimensional polyline has the drawing's coordinates, all others may be seen from
    // behind.
    const bool flat = (flags_ & 8) == 0;
    plane_ = flat ? plane.at(realOf(polyline, 30, 0.0)) : Eigen::Affine2d::Identity();
    entity->tilt = flat ? tiltOf(plane) : 0.0;
    if ((flags_ & (16 | 64)) != 0)
      entity->fault = "is a mesh, not a contour; draw the part's outline flat";
  } catch (const std::runtime_error& e) {
    entity->fault = e.what();
  }
}

void PolylineReader::add(const DxfRecord& vertex, DxfEntity* entity) {
  if (!entity->fault.empty()) return;
  try {
    // The frame that a spline was fitted to is not part of the curve.
    if ((integerOf(vertex, 70, 0) & 16) != 0) return;
    vertices_.push_back({pointOf(vertex, 10), realOf(vertex, 42, 0.0)});
  } catch (const std::runtime_error& e) {
    entity->fault = e.what();
  }
}

void PolylineReader::finish(DxfEntity* entity) {
  if (entity->fault.empty())
    entity->curve = placed(makePolyline(std::move(vertices_), (flags_ & 1) != 0), plane_);
  vertices_ = {};
}

std::optional<DxfDimension> readDimension(const DxfRecord& record, const DxfNames& names) {
  DxfDimension dimension;
  try {
    const int type = integerOf(record, 70, 0) & 15;  // without flags
    const Eigen::Vector2d a = pointOf(record, 13), b = pointOf(record, 14);
    const double turn = realOf(record, 50, 0.0) * kDegree;
    switch (type) {
      case 0:
        dimension.drawn = std::abs((b - a).dot(Eigen::Vector2d(std::cos(turn), std::sin(turn))));
        break;
      case 1:
        dimension.drawn = (b - a).norm();
        break;
      case 3:
      case 4:
        dimension.drawn = (pointOf(record, 15) - pointOf(record, 10)).norm();
        break;
      default:
        return std::nullopt;
    }
    if (!(dimension.drawn > 0.0)) return std::nullopt;
    const double measured = realOf(record, 42, 0.0);
    if (measured > 0.0) dimension.measured = measured;
    dimension.written = writtenNumber(names.decode(textOf(record, 1, "")));
    dimension.factor = overriddenFactor(record);
  } catch (const std::runtime_error&) {
    // A dimension is never an edge: one that is damaged is no evidence, and no reason to refuse.
    return std::nullopt;
  }
  dimension.style = upperCase(names.decode(textOf(record, 3, "STANDARD")));
  return dimension;
}

}  // namespace planar_bin_picking
