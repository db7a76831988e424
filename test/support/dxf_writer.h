// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Writes small DXF files as text, group by group, so that tests show what they read.

#include <initializer_list>
#include <locale>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace planar_bin_picking {

/// One group's value: a number or a word.
class DxfValue {
 public:
  DxfValue(const char* text) : text_(text) {}         // NOLINT: implicit on purpose
  DxfValue(const std::string& text) : text_(text) {}  // NOLINT
  DxfValue(double number) {                           // NOLINT
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(16);
    out << number;
    text_ = out.str();
  }
  DxfValue(int number) : DxfValue(std::to_string(number)) {}  // NOLINT
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

using DxfGroups = std::vector<std::pair<int, DxfValue>>;

inline std::string toText(const DxfGroups& groups) {
  std::string text;
  for (const auto& [code, value] : groups)
    text += std::to_string(code) + "\n" + value.text() + "\n";
  return text;
}

class DxfWriter {
 public:
  /// 4 = millimetres; -1 = no $INSUNITS in the file.
  explicit DxfWriter(int insunits = 4) : insunits_(insunits) {}

  /// A variable of the header.
  DxfWriter& variable(const std::string& name, const DxfGroups& groups) {
    header_ += toText({{9, name}}) + toText(groups);
    return *this;
  }
  /// Lengths of dashes, negative for gaps, 0 for dots; none = a continuous line.
  DxfWriter& lineType(const std::string& name, const std::vector<double>& pattern) {
    DxfGroups groups = {{0, "LTYPE"}, {2, name}, {70, 0}, {73, static_cast<int>(pattern.size())}};
    for (const double dash : pattern) groups.emplace_back(49, dash);
    layers_ += toText(groups);
    return *this;
  }
  DxfWriter& dimensionStyle(const std::string& name, double factor) {
    layers_ += toText({{0, "DIMSTYLE"}, {2, name}, {70, 0}, {144, factor}});
    return *this;
  }

  /// A negative colour switches the layer off, flag 1 freezes it.
  DxfWriter& layer(const std::string& name, int color = 7, int flags = 0,
                   const std::string& linetype = "Continuous") {
    layers_ += toText({{0, "LAYER"}, {2, name}, {70, flags}, {62, color}, {6, linetype}});
    return *this;
  }

  /// Entities that follow stand in this block, until endBlock().
  DxfWriter& block(const std::string& name, double base_x = 0.0, double base_y = 0.0, int flags = 0,
                   const std::string& path = "") {
    blocks_ += toText({{0, "BLOCK"}, {8, "0"}, {2, name}, {70, flags}, {10, base_x}, {20, base_y}});
    if (!path.empty()) blocks_ += toText({{1, path}});
    in_block_ = true;
    return *this;
  }
  DxfWriter& endBlock() {
    blocks_ += toText({{0, "ENDBLK"}, {8, "0"}});
    in_block_ = false;
    return *this;
  }

  DxfWriter& entity(const std::string& type, const std::string& layer, const DxfGroups& groups) {
    (in_block_ ? blocks_ : entities_) += toText({{0, type}, {8, layer}}) + toText(groups);
    return *this;
  }
  DxfWriter& line(double x0, double y0, double x1, double y1, const std::string& layer = "CUT") {
    return entity("LINE", layer, {{10, x0}, {20, y0}, {11, x1}, {21, y1}});
  }
  DxfWriter& circle(double x, double y, double radius, const std::string& layer = "CUT") {
    return entity("CIRCLE", layer, {{10, x}, {20, y}, {40, radius}});
  }
  DxfWriter& arc(double x, double y, double radius, double start_deg, double end_deg,
                 const std::string& layer = "CUT") {
    return entity("ARC", layer, {{10, x}, {20, y}, {40, radius}, {50, start_deg}, {51, end_deg}});
  }
  /// x, y, bulge of each vertex.
  DxfWriter& polyline(const std::vector<std::vector<double>>& vertices, bool closed = true,
                      const std::string& layer = "CUT") {
    DxfGroups groups = {{90, static_cast<int>(vertices.size())}, {70, closed ? 1 : 0}};
    for (const std::vector<double>& v : vertices) {
      groups.insert(groups.end(), {{10, v[0]}, {20, v[1]}});
      if (v.size() > 2) groups.emplace_back(42, v[2]);
    }
    return entity("LWPOLYLINE", layer, groups);
  }
  DxfWriter& rectangle(double x0, double y0, double x1, double y1,
                       const std::string& layer = "CUT") {
    return polyline({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, true, layer);
  }
  DxfWriter& insert(const std::string& block, double x, double y, const DxfGroups& groups = {},
                    const std::string& layer = "0") {
    DxfGroups all = {{2, block}, {10, x}, {20, y}};
    all.insert(all.end(), groups.begin(), groups.end());
    return entity("INSERT", layer, all);
  }

  std::string text() const {
    std::string header = header_;
    if (insunits_ >= 0) header += toText({{9, "$INSUNITS"}, {70, insunits_}});
    const auto section = [](const std::string& name, const std::string& content) {
      return toText({{0, "SECTION"}, {2, name}}) + content + toText({{0, "ENDSEC"}});
    };
    return section("HEADER", header) +
           section("TABLES",
                   toText({{0, "TABLE"}, {2, "LAYER"}}) + layers_ + toText({{0, "ENDTAB"}})) +
           section("BLOCKS", blocks_) + section("ENTITIES", entities_) + toText({{0, "EOF"}});
  }

 private:
  int insunits_;
  bool in_block_ = false;
  std::string header_, layers_, blocks_, entities_;
};

}  // namespace planar_bin_picking
