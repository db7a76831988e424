// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/edge_selection.h"

#include "drawing/dxf/dxf_names.h"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// More than any single part has; placements of blocks count, also of empty ones.
constexpr std::size_t kPlacedMax = 200000, kPointsMax = 500000;
constexpr std::size_t kCopiesMax = 10000;  // of one block by the rows and columns of one INSERT
/// What is passed over is looked at only for an outline or holes among it.
constexpr std::size_t kPassedOverMax = 5000, kPassedPointsMax = 50000;
constexpr int kDepthMax = 32;  // of blocks in blocks

/// Symbols that CAD programs put onto the outline's layer as blocks.
const std::vector<std::string> kCentreMarkBlocks = {
    "SW_CENTERMARKSYMBOL*", "*CENTERMARK*",  "*CENTREMARK*",  "*CENTER_MARK*", "*CENTRE_MARK*",
    "*CENTER MARK*",        "*CENTRE MARK*", "*CENTER-MARK*", "*CENTRE-MARK*", "*MITTENKREUZ*",
    "*MITTELPUNKT*",        "*MITTENMARK*",  "ACMCENTER*"};
const std::vector<std::string> kAnnotationBlocks = {
    "SW_NOTE*", "SW_TABLEANNOTATION*", "SW_WELDSYMBOL*", "SW_SFSYMBOL*",
    "SW_GTOL*", "SW_DATUMTAG*",        "SW_BALLOON*"};

/// R12 draws dimensions and hatches as blocks without a name of their own: *D1, *X2.
bool isAnonymous(const std::string& block, char kind) {
  return block.size() > 2 && block[0] == '*' && (block[1] & ~0x20) == kind &&
         block.find_first_not_of("0123456789", 2) == std::string::npos;
}

/// What a block takes over from the INSERT that places it.
struct Inherited {
  Eigen::Affine2d placement = Eigen::Affine2d::Identity();  ///< block -> mm
  std::string layer = "0", linetype = "CONTINUOUS";
  bool print = false;
  double tilt = 0.0;
  int depth = 0;
  std::string skipped;  ///< the layer of the default list on which all of it stands
};

/// Picks the edges and prints out of a file and places them.
class Selector {
 public:
  Selector(const DxfFile& file, const DrawingParams& params)
      : file_(file),
        params_(params),
        skips_by_default_(params.skip_layers == DrawingParams().skip_layers) {}

  EdgeSelection run(double mm_per_unit) {
    Inherited top;
    top.placement = Eigen::Scaling(mm_per_unit);
    for (const DxfEntity& entity : file_.entities) place(entity, top);
    noteUnusedBlocks();
    for (const std::string& note : notes_) out_.notes.push_back(note);
    return std::move(out_);
  }

 private:
  static std::string nameOf(const DxfEntity& entity, const std::string& layer) {
    return entity.type + " on layer \"" + layer + "\"";
  }

  DxfLayer layerOf(const std::string& name) const {
    const auto it = file_.layers.find(upperCase(name));
    return it == file_.layers.end() ? DxfLayer() : it->second;
  }

  void leaveOut(const std::string& reason) { ++out_.left_out[reason]; }

  /// Whether there is room for one more entity or placement.
  bool count(const Inherited& from) {
    if (!from.skipped.empty()) return ++passed_placed_ <= kPassedOverMax;
    if (++placed_ <= kPlacedMax) return true;
    throw std::runtime_error("has more than " + std::to_string(kPlacedMax) +
                             " entities: no single part");
  }

  void place(const DxfEntity& entity, const Inherited& from) {
    if (!count(from) || entity.type == "VIEWPORT") return;
    if (const DxfBlock* block = blockOf(entity)) used_.insert(block);
    const std::string layer_name = entity.layer == "0" ? from.layer : entity.layer;
    const DxfLayer layer = layerOf(layer_name);
    const std::string by = upperCase(entity.linetype);
    Inherited own = from;
    own.layer = layer_name;
    own.linetype = by == "BYLAYER"   ? layer.linetype
                   : by == "BYBLOCK" ? from.linetype
                                     : entity.linetype;
    own.print = from.print || matchesAny(layer_name, params_.print_layers);
    own.tilt = from.tilt + entity.tilt;
    if (!from.skipped.empty()) return passOver(entity, own);
    if (entity.on_paper) return leaveOut("paper space");
    if (entity.invisible) return leaveOut("invisible");
    const bool insert = entity.kind == DxfKind::kInsert;
    if (layer.frozen) return leaveOut("layer " + layer_name + " (frozen)");
    // A block's contents may stand on other layers: its own layer decides only what hides it whole.
    if (layer.off && !insert) return leaveOut("layer " + layer_name + " (off)");
    if (matchesAny(layer_name, params_.skip_layers)) {
      leaveOut("layer " + layer_name);
      own.skipped = layer_name;
      if (skips_by_default_) passOver(entity, own);
      return;
    }
    if (insert) return placeInsert(entity, own);
    if (!params_.keep_layers.empty() && !matchesAny(layer_name, params_.keep_layers))
      return leaveOut("layer " + layer_name);
    if (entity.kind == DxfKind::kText) return leaveOut("text and dimensions");
    if (entity.kind == DxfKind::kHatch) return leaveOut("hatches and fillings");
    if (entity.kind == DxfKind::kOther) return leaveOut(entity.type);
    placeCurve(entity, own);
  }

  void placeCurve(const DxfEntity& entity, const Inherited& own) {
    const LineMeaning meaning = meaningOf(own.linetype, file_);
    std::string annotation;
    if (meaning == LineMeaning::kAnnotation || meaning == LineMeaning::kNeighbour) {
      if (params_.keep_layers.empty() || own.print) {
        leaveOut("line type " + own.linetype);
        return rememberPassedOver(entity, own, true, own.linetype, meaning);
      }
      annotation = own.linetype;
    }
    if (entity.kind == DxfKind::kUnreadable) {
      throw std::runtime_error(nameOf(entity, own.layer) +
                               " cannot be read; explode it into lines, arcs and splines, or list "
                               "its layer in skip_layers");
    }
    throwFault(entity, own.layer, entity.fault);
    if (meaning == LineMeaning::kUnknown) ++out_.unknown_linetypes[own.linetype];
    if (entity.curve.breaks.empty()) return leaveOut(entity.type + " without length");
    Stroke stroke;
    try {
      stroke = strokeOf(entity, own, kPointsMax - points_);
    } catch (const std::runtime_error& e) {
      throwFault(entity, own.layer, e.what());
    }
    stroke.annotation = annotation;
    points_ += stroke.points.size();
    (own.print ? out_.prints : out_.edges).push_back(std::move(stroke));
  }

  static void throwFault(const DxfEntity& entity, const std::string& layer,
                         const std::string& fault) {
    if (fault.empty()) return;
    const bool with_line = fault.rfind("line ", 0) == 0;
    throw std::runtime_error(nameOf(entity, layer) + (with_line ? ": " : " ") + fault);
  }

  Stroke strokeOf(const DxfEntity& entity, const Inherited& own, std::size_t points_max) const {
    Stroke stroke;
    stroke.type = entity.type;
    stroke.layer = own.layer;
    stroke.points = flatten(entity.curve, own.placement, params_.chord_tolerance_mm, points_max);
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& p : stroke.points) box.extend(p);
    if (box.sizes().norm() * own.tilt > params_.join_tolerance_mm)
      throw std::runtime_error("does not lie in the xy plane; draw the part flat, seen from above");
    for (const Eigen::Vector2d& center : entity.curve.centers)
      stroke.centers.push_back(own.placement * center);
    const bool comes_round = stroke.points.size() > 2 &&
                             (stroke.points.front() - stroke.points.back()).norm() <= kExactMm;
    stroke.closed = entity.curve.closed || comes_round;
    if (stroke.closed) stroke.points.back() = stroke.points.front();
    return stroke;
  }

  /// What stands on a layer that is left out: no fault of it may refuse the part.
  void passOver(const DxfEntity& entity, const Inherited& own) {
    if (entity.on_paper || entity.invisible || !entity.fault.empty()) return;
    const DxfLayer layer = layerOf(own.layer);
    if (layer.frozen || layer.off) return;
    if (entity.kind == DxfKind::kInsert) {
      const DxfBlock* block = blockOf(entity);
      if (block == nullptr || own.depth >= kDepthMax || isDrawnByDimension(*block)) return;
      placeCopies(*entity.insert, *block, own);
    } else if (entity.kind == DxfKind::kCurve &&
               meaningOf(own.linetype, file_) == LineMeaning::kEdge) {
      rememberPassedOver(entity, own, false, own.skipped, LineMeaning::kEdge);
    }
  }

  void rememberPassedOver(const DxfEntity& entity, const Inherited& own, bool by_line_type,
                          const std::string& name, LineMeaning meaning) {
    if (out_.passed_over.size() >= kPassedOverMax || !entity.fault.empty() ||
        entity.curve.breaks.empty() || passed_points_ >= kPassedPointsMax)
      return;
    try {
      Stroke stroke = strokeOf(entity, own, kPassedPointsMax - passed_points_);
      passed_points_ += stroke.points.size();
      out_.passed_over.push_back({std::move(stroke), by_line_type, name, meaning});
    } catch (const std::runtime_error&) {
      // Left out already: it is no reason to refuse the part, whatever is wrong with it.
      return;
    }
  }

  const DxfBlock* blockOf(const DxfEntity& insert) const {
    if (insert.insert == nullptr) return nullptr;
    const auto block = file_.blocks.find(upperCase(insert.insert->block));
    return block == file_.blocks.end() ? nullptr : &block->second;
  }

  static bool isDrawnByDimension(const DxfBlock& block) {
    return isAnonymous(block.name, 'D') || isAnonymous(block.name, 'T');
  }

  void placeInsert(const DxfEntity& entity, const Inherited& own) {
    throwFault(entity, own.layer, entity.fault);
    const std::string name =
        "INSERT of block \"" + entity.insert->block + "\" on layer \"" + own.layer + "\"";
    const DxfBlock* block = blockOf(entity);
    if (block == nullptr)
      throw std::runtime_error(name + ": the block is not in the file; bind or explode it");
    if (isDrawnByDimension(*block)) return leaveOut("text and dimensions");
    if (isAnonymous(block->name, 'X')) return leaveOut("hatches and fillings");
    if (matchesAny(block->name, kCentreMarkBlocks)) {
      notes_.insert("block " + block->name + ": centre mark");
      return;
    }
    if (matchesAny(block->name, kAnnotationBlocks)) {
      notes_.insert("block " + block->name + ": annotation");
      return;
    }
    if (!block->external.empty()) {
      throw std::runtime_error(name + " is an external reference to \"" + block->external +
                               "\", whose content is not in this file; bind it in the CAD program "
                               "and export again, or list its layer in skip_layers");
    }
    if (own.depth >= kDepthMax) throw std::runtime_error(name + " contains itself; explode it");
    const std::size_t copies = static_cast<std::size_t>(entity.insert->columns) *
                               static_cast<std::size_t>(entity.insert->rows);
    if (copies > kCopiesMax) {
      throw std::runtime_error(name + " repeats it more than " + std::to_string(kCopiesMax) +
                               " times; explode it");
    }
    placeCopies(*entity.insert, *block, own);
  }

  void placeCopies(const DxfInsert& insert, const DxfBlock& block, Inherited own) {
    const Eigen::Affine2d outside = own.placement;
    ++own.depth;
    for (int row = 0; row < insert.rows; ++row) {
      for (int column = 0; column < insert.columns; ++column) {
        if (!count(own)) return;
        own.placement = outside * Eigen::Translation2d(row * insert.row + column * insert.column) *
                        insert.placement * Eigen::Translation2d(-block.base_point);
        for (const DxfEntity& entity : block.entities) place(entity, own);
      }
    }
  }

  /// Only of use where nothing else is drawn; then it says where the part is.
  void noteUnusedBlocks() {
    if (!out_.edges.empty()) return;
    for (const auto& [key, block] : file_.blocks) {
      const std::size_t curves = static_cast<std::size_t>(
          std::count_if(block.entities.begin(), block.entities.end(),
                        [](const DxfEntity& e) { return e.kind == DxfKind::kCurve; }));
      if (curves == 0 || used_.count(&block) != 0) continue;
      if (key.rfind("*PAPER_SPACE", 0) == 0) {
        out_.left_out["paper space"] += curves;
      } else if (key[0] != '*') {
        out_.left_out["block " + block.name + ", which no INSERT places"] += curves;
      }
    }
  }

  const DxfFile& file_;
  const DrawingParams& params_;
  bool skips_by_default_;
  EdgeSelection out_;
  std::set<std::string> notes_;
  std::set<const DxfBlock*> used_;
  std::size_t placed_ = 0, points_ = 0, passed_placed_ = 0, passed_points_ = 0;
};

}  // namespace

EdgeSelection selectEdges(const DxfFile& file, const DrawingParams& params, double mm_per_unit) {
  return Selector(file, params).run(mm_per_unit);
}

std::string countText(const std::string& what, std::size_t count) {
  return what + ": " + std::to_string(count) + (count == 1 ? " entity" : " entities");
}

}  // namespace planar_bin_picking
