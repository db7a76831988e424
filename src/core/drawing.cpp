// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/drawing.h"

#include "contours.h"
#include "dxf_reader.h"
#include "polygon.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <set>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// Line types that draughtsmen use for what is not a visible edge.
const std::vector<std::string> kAnnotationLinetypes = {"CENTER*", "HIDDEN*", "PHANTOM*", "DASH*",
                                                       "ACAD_ISO*"};

/// `*` in the pattern stands for anything; both in upper case.
bool matches(const std::string& text, const std::string& pattern, std::size_t i = 0,
             std::size_t j = 0) {
  for (; j < pattern.size(); ++i, ++j) {
    if (pattern[j] == '*') {
      for (std::size_t rest = i; rest <= text.size(); ++rest) {
        if (matches(text, pattern, rest, j + 1)) return true;
      }
      return false;
    }
    if (i == text.size() || text[i] != pattern[j]) return false;
  }
  return i == text.size();
}

bool matchesAny(const std::string& text, const std::vector<std::string>& patterns) {
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](const std::string& pattern) { return matches(text, upperCase(pattern)); });
}

/// What a block takes over from the INSERT that places it.
struct Inherited {
  Eigen::Affine2d placement;  ///< block -> mm
  std::string layer = "0", linetype = "CONTINUOUS";
  bool print = false;
  int depth = 0;
};

/// Picks the edges and prints out of a file and places them.
class Selection {
 public:
  Selection(const DxfFile& file, const DrawingParams& params) : file_(file), params_(params) {}

  void run() {
    for (const UnreadableEntity& entity : file_.unreadable) {
      if (!isWanted(upperCase(entity.layer))) continue;
      throw std::runtime_error(entity.type + " on layer \"" + entity.layer +
                               "\" cannot be read; explode it into lines, arcs and splines");
    }
    Inherited top;
    top.placement = Eigen::Scaling(file_.mm_per_unit);
    for (const DxfEntity& entity : file_.entities) place(entity, top);
  }

  std::vector<Stroke> edges, prints;
  std::set<std::string> left_out;  ///< why things were left out, for the message if nothing remains

 private:
  bool isSkipped(const std::string& layer) const { return matchesAny(layer, params_.skip_layers); }
  bool isWanted(const std::string& layer) const {
    return !isSkipped(layer) &&
           (params_.keep_layers.empty() || matchesAny(layer, params_.keep_layers));
  }

  DxfLayer layerOf(const std::string& name) const {
    const auto it = file_.layers.find(name);
    return it == file_.layers.end() ? DxfLayer() : it->second;
  }

  void place(const DxfEntity& entity, const Inherited& from) {
    if (++placed_ > 200000) {
      throw std::runtime_error("has more than 200000 entities: no single part");
    }
    const std::string layer_name = entity.layer == "0" ? from.layer : entity.layer;
    const DxfLayer layer = layerOf(layer_name);
    const std::string linetype = entity.linetype == "BYLAYER"   ? layer.linetype
                                 : entity.linetype == "BYBLOCK" ? from.linetype
                                                                : entity.linetype;
    const bool insert = entity.type == "INSERT";
    const std::string where = "layer \"" + layer_name + "\"";
    // A block's contents may stand on other layers: its own layer decides only what hides it whole.
    if (layer.frozen || (layer.off && !insert)) return leaveOut(where + " is switched off");
    if (isSkipped(layer_name)) return leaveOut(where + " is skipped");
    if (!insert && !isWanted(layer_name)) return leaveOut(where + " is not in keep_layers");
    if (!insert && matchesAny(linetype, kAnnotationLinetypes)) {
      return leaveOut("line type " + linetype + " is annotation");
    }
    const bool print = from.print || matchesAny(layer_name, params_.print_layers);
    if (insert)
      return placeBlock(entity, {from.placement, layer_name, linetype, print, from.depth + 1});
    Stroke stroke{entity.type, layer_name, {}};
    stroke.points = flatten(entity.curve, from.placement, params_.chord_tolerance_mm);
    if (!stroke.points.empty()) (print ? prints : edges).push_back(std::move(stroke));
  }

  void placeBlock(const DxfEntity& insert, Inherited inside) {
    const auto block = file_.blocks.find(insert.block);
    const std::string name =
        "INSERT of block \"" + insert.block + "\" on layer \"" + insert.layer + "\"";
    if (block == file_.blocks.end()) {
      throw std::runtime_error(name + ": the block is not in the file; bind or explode it");
    }
    if (inside.depth > 32) throw std::runtime_error(name + " contains itself; explode it");
    const Eigen::Affine2d outside = inside.placement;
    for (const Eigen::Affine2d& placement : insert.placements) {
      inside.placement = outside * placement * Eigen::Translation2d(-block->second.base_point);
      for (const DxfEntity& entity : block->second.entities) place(entity, inside);
    }
  }

  void leaveOut(const std::string& reason) { left_out.insert(reason); }

  const DxfFile& file_;
  const DrawingParams& params_;
  std::size_t placed_ = 0;
};

/// Points closer than this to the one before carry no shape, only trouble.
constexpr double kSamePointMm = 1e-4;

void dropRepeated(Contour* contour) {
  std::vector<Eigen::Vector2d> kept;
  for (const Eigen::Vector2d& p : contour->points) {
    if (kept.empty() || (p - kept.back()).norm() > kSamePointMm) kept.push_back(p);
  }
  while (contour->closed && kept.size() > 1 &&
         (kept.front() - kept.back()).norm() <= kSamePointMm) {
    kept.pop_back();
  }
  contour->points = std::move(kept);
}

void checkCrossings(const std::vector<Contour>& contours) {
  std::vector<Polygon> polygons;
  for (const Contour& contour : contours) polygons.push_back(contour.points);
  const auto crossing = findCrossing(polygons, kSamePointMm);
  if (!crossing) return;
  const Contour &a = contours[crossing->first], &b = contours[crossing->second];
  const std::string what =
      crossing->first == crossing->second
          ? "the contour with " + nameOf(a) + " crosses or touches itself"
          : "the contours with " + nameOf(a) + " and " + nameOf(b) + " cross or touch";
  throw std::runtime_error(
      what + " at " + inMm(crossing->point) +
      ". Correct the drawing, or list the layer in skip_layers if it is no edge");
}

std::string boxText(const Contour& contour) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : contour.points) box.extend(p);
  return "from " + inMm(box.min()) + " to " + inMm(box.max());
}

/// The outer contour first, the holes after it in their order.
std::vector<Loop> classify(const std::vector<Contour>& contours) {
  std::size_t outer = 0;
  for (std::size_t i = 1; i < contours.size(); ++i) {
    if (std::abs(signedArea(contours[i].points)) > std::abs(signedArea(contours[outer].points)))
      outer = i;
  }
  std::vector<Loop> loops = {{LoopKind::kOuter, true, contours[outer].points}};
  for (std::size_t i = 0; i < contours.size(); ++i) {
    if (i == outer) continue;
    const Eigen::Vector2d& p = contours[i].points.front();
    if (!contains(contours[outer].points, p)) {
      throw std::runtime_error(
          "has several outer contours: with " + nameOf(contours[outer]) + " " +
          boxText(contours[outer]) + ", with " + nameOf(contours[i]) + " " + boxText(contours[i]) +
          ". Draw one part per file, or list the layer of the others in skip_layers");
    }
    for (std::size_t k = 0; k < contours.size(); ++k) {
      if (k == i || k == outer || !contains(contours[k].points, p)) continue;
      throw std::runtime_error(
          "the contour with " + nameOf(contours[i]) + " " + boxText(contours[i]) +
          " lies inside a hole, that with " + nameOf(contours[k]) + " " + boxText(contours[k]) +
          ". Remove a frame around the part; list the layer of countersinks and "
          "threads in skip_layers");
    }
    loops.push_back({LoopKind::kHole, true, contours[i].points});
  }
  for (Loop& loop : loops) {
    const bool counter_clockwise = signedArea(loop.points) > 0.0;
    if (counter_clockwise != (loop.kind == LoopKind::kOuter))
      std::reverse(loop.points.begin(), loop.points.end());
  }
  return loops;
}

std::string nothingDrawn(const Selection& selection) {
  std::string text = "no outline is drawn in it";
  std::string reasons;
  for (const std::string& reason : selection.left_out)
    reasons += (reasons.empty() ? "" : ", ") + reason;
  if (!reasons.empty()) text += "; what it has was left out: " + reasons;
  return text +
         ". Draw the outline on a visible layer with a continuous line, or name its layer in "
         "keep_layers";
}

void checkSize(const std::vector<Contour>& contours) {
  Eigen::AlignedBox2d box;
  for (const Contour& contour : contours) {
    for (const Eigen::Vector2d& p : contour.points) box.extend(p);
  }
  const double size = box.sizes().maxCoeff();
  if (size >= 1.0 && size <= 10e3) return;
  std::ostringstream text;
  text << "the part would be " << size
       << " mm large, allowed are 1 mm to 10 m; check the drawing's "
       << "unit ($INSUNITS)";
  throw std::runtime_error(text.str());
}

/// A print beside the part is none: a title, or another part's.
void checkOnPart(const Contour& print, const Loop& outer) {
  constexpr double kMarginMm = 1.0;  // half a stroke may hang over
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : outer.points) box.extend(p);
  for (const Eigen::Vector2d& p : print.points) {
    if (box.exteriorDistance(p) <= kMarginMm) continue;
    throw std::runtime_error("the print with " + nameOf(print) + " " + boxText(print) +
                             " is not on the part. List its layer in skip_layers");
  }
}

Drawing assemble(const DxfFile& file, const DrawingParams& params) {
  Selection selection(file, params);
  selection.run();
  const double tolerance = params.join_tolerance_mm;
  const std::vector<Stroke> edges = withoutDuplicates(selection.edges, tolerance);
  if (edges.empty()) throw std::runtime_error(nothingDrawn(selection));
  std::vector<Contour> contours = chainClosed(edges, tolerance);
  for (Contour& contour : contours) dropRepeated(&contour);
  checkSize(contours);
  checkCrossings(contours);
  Drawing drawing{classify(contours)};
  for (Contour& print : chainAny(withoutDuplicates(selection.prints, tolerance), tolerance)) {
    dropRepeated(&print);
    checkOnPart(print, drawing.loops.front());
    drawing.loops.push_back({LoopKind::kPrint, print.closed, std::move(print.points)});
  }
  for (Loop& loop : drawing.loops) {
    for (Eigen::Vector2d& p : loop.points) p *= 1e-3;
  }
  return drawing;
}

}  // namespace

double lengthOf(const Loop& loop) {
  double length = 0.0;
  const std::size_t n = loop.points.size();
  for (std::size_t i = 0; i + (loop.closed ? 0 : 1) < n; ++i) {
    length += (loop.points[(i + 1) % n] - loop.points[i]).norm();
  }
  return length;
}

Drawing loadDrawing(const std::string& path, const DrawingParams& params) {
  try {
    return assemble(readDxf(path), params);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
}

}  // namespace planar_bin_picking
