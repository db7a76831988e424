// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dxf_reader.h"

#include <dxflib/dl_creationadapter.h>
#include <dxflib/dl_dxf.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

double mmPerUnit(int insunits) {
  static const std::map<int, double> kKnown = {
      {0, 1.0},     {1, 25.4},           {2, 304.8},         {3, 1609344.0},
      {4, 1.0},     {5, 10.0},           {6, 1000.0},        {7, 1e6},
      {8, 25.4e-6}, {9, 25.4e-3},        {10, 914.4},        {11, 1e-7},
      {12, 1e-6},   {13, 1e-3},          {14, 100.0},        {15, 1e4},
      {16, 1e5},    {21, 1200e3 / 3937}, {22, 100e3 / 3937}, {23, 3600e3 / 3937}};
  const auto it = kKnown.find(insunits);
  if (it != kKnown.end()) return it->second;
  throw std::runtime_error(
      "$INSUNITS is " + std::to_string(insunits) +
      ", a unit that no part is drawn in; set the drawing's unit to millimetres "
      "($INSUNITS 4)");
}

/// dxflib parses numbers by the process's C++ locale; where that has decimal commas it would cut
/// them. Where it has none, which is nearly always, it is not touched: other threads may be using
/// it.
class ClassicLocale {
 public:
  ClassicLocale() { switchTo(std::locale::classic()); }
  ~ClassicLocale() { switchTo(before_); }
  ClassicLocale(const ClassicLocale&) = delete;
  ClassicLocale& operator=(const ClassicLocale&) = delete;

 private:
  static void switchTo(const std::locale& locale) {
    if (std::locale() != locale) std::locale::global(locale);
  }
  std::locale before_;
};

/// Collects what dxflib finds.
class Collector : public DL_CreationAdapter {
 public:
  explicit Collector(DxfFile* file) : file_(file) {}

  void setVariableInt(const std::string& key, int value, int) override {
    if (key == "$INSUNITS") file_->mm_per_unit = mmPerUnit(value);
  }

  void addLayer(const DL_LayerData& data) override {
    DxfLayer layer;
    layer.off = attributes.getColor() < 0;
    layer.frozen = (data.flags & 1) != 0;
    layer.linetype = upperCase(attributes.getLinetype());
    file_->layers[upperCase(data.name)] = layer;
  }

  void addBlock(const DL_BlockData& data) override {
    block_ = &file_->blocks[upperCase(data.name)];
    block_->base_point = {data.bpx, data.bpy};
  }
  void endBlock() override { block_ = nullptr; }

  void addLine(const DL_LineData& d) override {
    begin("LINE");
    finish(makeLine({d.x1, d.y1}, {d.x2, d.y2}));
  }

  void addArc(const DL_ArcData& d) override {
    begin("ARC");
    finish(makeArc({d.cx, d.cy}, d.radius, d.angle1 * kDegree, d.angle2 * kDegree));
  }

  void addCircle(const DL_CircleData& d) override {
    begin("CIRCLE");
    finish(makeArc({d.cx, d.cy}, d.radius, 0.0, 0.0));
  }

  void addEllipse(const DL_EllipseData& d) override {
    begin("ELLIPSE");
    const Eigen::Vector2d major(d.mx, d.my);
    const Eigen::Vector2d minor = d.ratio * (flipped_ ? -1.0 : 1.0) * Eigen::Vector2d(-d.my, d.mx);
    finish(makeEllipse({d.cx, d.cy}, major, minor, d.angle1, d.angle2));
  }

  void addPolyline(const DL_PolylineData& d) override {
    begin("POLYLINE");
    if ((d.flags & (16 | 64)) != 0)
      refuse("is a mesh, not a contour; draw the part's outline flat");
    polyline_flags_ = d.flags;
    vertices_.clear();
  }

  void addVertex(const DL_VertexData& d) override {
    if (entity_.type != "POLYLINE") return;
    // A three-dimensional polyline has world coordinates, all others may be seen from behind.
    const bool flipped = flipped_ && (polyline_flags_ & 8) == 0;
    const double side = flipped ? -1.0 : 1.0;
    vertices_.push_back({{side * d.x, d.y}, side * d.bulge});
  }

  void addSpline(const DL_SplineData& d) override {
    begin("SPLINE");
    spline_ = SplineData();
    spline_.degree = static_cast<int>(d.degree);
    spline_.closed = (d.flags & 1) != 0;
    spline_.start_tangent = {d.tangentStartX, d.tangentStartY};
    spline_.end_tangent = {d.tangentEndX, d.tangentEndY};
  }
  void addControlPoint(const DL_ControlPointData& d) override {
    spline_.control_points.emplace_back(d.x, d.y);
    spline_.weights.push_back(d.w);
  }
  void addFitPoint(const DL_FitPointData& d) override { spline_.fit_points.emplace_back(d.x, d.y); }
  void addKnot(const DL_KnotData& d) override { spline_.knots.push_back(d.k); }

  /// dxflib calls this after the last part of a polyline or a spline.
  void endEntity() override {
    if (entity_.type == "POLYLINE") finish(makePolyline(vertices_, (polyline_flags_ & 1) != 0));
    if (entity_.type == "SPLINE") {
      try {
        finish(makeSpline(spline_));
      } catch (const std::runtime_error& e) {
        refuse(e.what());
      }
    }
  }

  void addInsert(const DL_InsertData& d) override {
    begin("INSERT");
    entity_.block = upperCase(d.name);
    const double count = static_cast<double>(std::max(1, d.cols)) * std::max(1, d.rows);
    if (count > 10000.0) refuse("of block \"" + d.name + "\" repeats it more than 10000 times");
    const Eigen::Affine2d seen_from(Eigen::Scaling(flipped_ ? -1.0 : 1.0, 1.0));
    for (int row = 0; row < std::max(1, d.rows); ++row) {
      for (int col = 0; col < std::max(1, d.cols); ++col) {
        entity_.placements.push_back(
            seen_from * Eigen::Translation2d(d.ipx, d.ipy) * Eigen::Rotation2Dd(d.angle * kDegree) *
            Eigen::Translation2d(col * d.colSp, row * d.rowSp) * Eigen::Scaling(d.sx, d.sy));
      }
    }
    finish({});
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw std::runtime_error(entity_.type + " on layer \"" + entity_.layer + "\" " + what);
  }

  /// Arcs and circles are given in a system of their own, which may be seen from behind.
  Curve makeArc(const Eigen::Vector2d& center, double radius, double start, double end) const {
    if (!(radius > 0.0)) refuse("has a radius that is not greater than 0; delete it");
    const double side = flipped_ ? -1.0 : 1.0;
    return makeEllipse({side * center.x(), center.y()}, {side * radius, 0.0}, {0.0, radius}, start,
                       end);
  }

  void begin(const std::string& type) {
    entity_ = DxfEntity();
    entity_.type = type;
    entity_.layer = upperCase(attributes.getLayer());
    entity_.linetype = upperCase(attributes.getLinetype());
    const Eigen::Vector3d normal(extrusion->getDirection());
    flipped_ = normal.z() < 0.0;
    if (normal.head<2>().norm() > 1e-6 * normal.norm()) {
      refuse("does not lie in the xy plane; draw the part flat, seen from above");
    }
  }

  void finish(const Curve& curve) {
    entity_.curve = curve;
    (block_ != nullptr ? block_->entities : file_->entities).push_back(entity_);
    entity_ = DxfEntity();
  }

  DxfFile* file_;
  DxfBlock* block_ = nullptr;
  DxfEntity entity_;
  bool flipped_ = false;  ///< the entity's extrusion points down
  int polyline_flags_ = 0;
  std::vector<BulgeVertex> vertices_;
  SplineData spline_;
};

}  // namespace

std::string upperCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(c < 128 ? std::toupper(c) : c); });
  return text;
}

DxfFile readDxf(const std::string& path) {
  DxfText checked = readDxfText(path);
  DxfFile file;
  file.unreadable = std::move(checked.unreadable);
  std::istringstream text(checked.text);
  Collector collector(&file);
  const ClassicLocale locale;
  DL_Dxf dxf;
  dxf.in(text, &collector);
  return file;
}

}  // namespace planar_bin_picking
