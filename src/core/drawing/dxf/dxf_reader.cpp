// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/dxf_reader.h"

#include "drawing/dxf/dxf_entity.h"
#include "drawing/dxf/dxf_names.h"
#include "drawing/dxf/dxf_text.h"

#include <cmath>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// More than any drawing of a part has, titles and tables included.
constexpr std::size_t kEntitiesMax = 300000;

/// Puts what the records say into its place.
class Reader {
 public:
  explicit Reader(std::string_view content) : text_(content) {}

  DxfFile read() {
    DxfRecord record;
    while (text_.next(&record)) add(record);
    finishPolyline();
    return std::move(file_);
  }

 private:
  void add(const DxfRecord& record) {
    const std::string_view type = record.front().value;
    if (record.front().code == 0) {
      if (type == "SECTION") section_ = textOf(record, 2, "");
      if (type == "SECTION" || type == "ENDSEC" || type == "EOF") return finishPolyline();
    }
    if (section_ == "HEADER") addVariable(record);
    if (section_ == "TABLES") addTableEntry(record);
    if (section_ == "BLOCKS" || section_ == "ENTITIES") addEntity(record);
  }

  void addVariable(const DxfRecord& record) {
    const std::string_view name = record.front().value;
    if (name == "$INSUNITS") file_.header.insunits = integerOf(record, 70, 0);
    if (name == "$MEASUREMENT") file_.header.measurement = integerOf(record, 70, 1);
    if (name == "$DIMLFAC") file_.header.dimension_factor = realOf(record, 40, 1.0);
    if (name == "$DWGCODEPAGE") code_page_ = textOf(record, 3, "");
    if (name == "$ACADVER") version_ = textOf(record, 1, "");
    names_ = DxfNames(code_page_, version_);
  }

  void addTableEntry(const DxfRecord& record) {
    const std::string_view type = record.front().value;
    const std::string name = upperCase(names_.decode(textOf(record, 2, "")));
    if (type == "LAYER") {
      DxfLayer& layer = file_.layers[name];
      layer.off = integerOf(record, 62, 7) < 0;
      layer.frozen = (integerOf(record, 70, 0) & 1) != 0;
      layer.linetype = names_.decode(textOf(record, 6, ""));
    }
    if (type == "DIMSTYLE") file_.dimension_factors[name] = realOf(record, 144, 1.0);
    if (type == "LTYPE") {
      bool gap = false;  // a gap or a dot
      for (std::size_t i = 1; i < record.size(); ++i) {
        gap = gap || (record[i].code == 49 && realOf(record[i], type) <= 0.0);
      }
      file_.dashed_linetypes[name] = gap;
    }
  }

  void addBlock(const DxfRecord& record) {
    const std::string name = names_.decode(textOf(record, 2, ""));
    block_ = &file_.blocks[upperCase(name)];
    block_->name = name;
    block_->base_point = {realOf(record, 10, 0.0), realOf(record, 20, 0.0)};
    constexpr int kExternal = 4 | 8;  // a reference, or one laid over
    if ((integerOf(record, 70, 0) & kExternal) != 0) {
      block_->external = names_.decode(textOf(record, 1, ""));
      if (block_->external.empty()) block_->external = name;
    }
  }

  void addEntity(const DxfRecord& record) {
    const std::string_view type = record.front().value;
    if (type == "VERTEX") {
      if (in_polyline_) polyline_.add(record, &entity_);
      return;
    }
    finishPolyline();
    if (type == "SEQEND" || record.front().code != 0) return;
    if (type == "BLOCK") return addBlock(record);
    if (type == "ENDBLK") {
      block_ = nullptr;
      return;
    }
    if (++count_ > kEntitiesMax) {
      throw std::runtime_error("has more than " + std::to_string(kEntitiesMax) +
                               " entities: no drawing of a single part");
    }
    entity_ = readEntity(record, names_);
    if (type == "DIMENSION" && block_ == nullptr && !entity_.on_paper && !entity_.invisible) {
      if (const auto dimension = readDimension(record, names_))
        file_.dimensions.push_back(*dimension);
    }
    in_polyline_ = type == "POLYLINE";
    if (in_polyline_) {
      polyline_.begin(record, &entity_);
    } else {
      keep();
    }
  }

  void finishPolyline() {
    if (!in_polyline_) return;
    polyline_.finish(&entity_);
    in_polyline_ = false;
    keep();
  }

  void keep() {
    (block_ != nullptr ? block_->entities : file_.entities).push_back(std::move(entity_));
  }

  DxfText text_;
  DxfFile file_;
  DxfNames names_;
  std::string code_page_, version_;
  std::string_view section_;
  DxfBlock* block_ = nullptr;
  DxfEntity entity_;
  PolylineReader polyline_;
  bool in_polyline_ = false;
  std::size_t count_ = 0;
};

}  // namespace

DxfFile readDxf(std::string_view content) { return Reader(content).read(); }

}  // namespace planar_bin_picking
