// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/drawing/drawing_file.h"

#include "base/regular_file.h"
#include "drawing/centre_marks.h"
#include "drawing/contours.h"
#include "drawing/dxf/drawing_units.h"
#include "drawing/dxf/dxf_reader.h"
#include "drawing/dxf/sheet_scale.h"
#include "drawing/edge_selection.h"
#include "drawing/part_contours.h"
#include "drawing/passed_over.h"
#include "drawing/strokes.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <set>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// Far more than the drawing of a part needs, embedded pictures left aside.
constexpr std::size_t kBytesMax = 64u << 20;
/// Of the tolerances: coarser chords, or joints over a wider gap, would change small holes.
constexpr double kChordMostMm = 1.0, kJoinMostMm = 5.0;
/// From the origin: there a hundredth of a degree moves the part by 17 mm.
constexpr double kFarMm = 100e3;
/// A part this small is rare in millimetres and common in inches (300 mm).
constexpr double kSmallMm = 12.0;
constexpr double kMarginMm =
    1.0;  // a print's stroke may reach beyond the outline by half its width

std::string number(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << value;
  return text.str();
}

void checkParams(const DrawingParams& params) {
  const auto check = [](const char* name, double value, double least, double most) {
    if (value >= least && value <= most) return;
    throw std::invalid_argument(std::string(name) + " is " + number(value) + ", must be between " +
                                number(least) + " and " + number(most));
  };
  check("chord_tolerance_mm", params.chord_tolerance_mm, kExactMm, kChordMostMm);
  check("join_tolerance_mm", params.join_tolerance_mm, kExactMm, kJoinMostMm);
}

std::string quotedLayers(const std::vector<Stroke>& strokes) {
  std::set<std::string> names;
  for (const Stroke& stroke : strokes) names.insert(stroke.layer);
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
  return text;
}

std::string joined(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
  return text;
}

/// The alphabet's order: the same file gives the same list.
std::vector<std::string> leftOutTexts(const EdgeSelection& selection) {
  std::vector<std::string> texts = selection.notes;
  for (const auto& [reason, count] : selection.left_out) texts.push_back(countText(reason, count));
  std::sort(texts.begin(), texts.end());
  return texts;
}

/// What would make an outline of what there is.
std::string remedyFor(const EdgeSelection& selection) {
  static const std::vector<std::pair<const char*, const char*>> kRemedies = {
      {"(off)", "switch its layer on"},
      {"(frozen)", "thaw its layer"},
      {"layer ", "name its layer in keep_layers"},
      {"line type ", "name its layer in keep_layers"},
      {"paper space", "draw it in model space"},
      {"hatches", "draw the border of a hatch as lines"},
      {"no INSERT", "insert its block"},
      {"invisible", "make it visible"}};
  std::vector<std::string> remedies;
  for (const auto& [reason, count] : selection.left_out) {
    for (const auto& [word, remedy] : kRemedies) {
      if (reason.find(word) == std::string::npos) continue;
      if (std::find(remedies.begin(), remedies.end(), remedy) == remedies.end())
        remedies.push_back(remedy);
      break;
    }
  }
  if (remedies.empty()) return "Draw the outline on a visible layer with a continuous line";
  return "If the outline is among it: " + joined(remedies);
}

[[noreturn]] void refuseNothingDrawn(const EdgeSelection& selection) {
  std::string text = "no outline is drawn in it";
  if (!selection.prints.empty()) {
    throw std::runtime_error(text + ": all that it has counts as print, by the name of layer " +
                             quotedLayers(selection.prints) +
                             ". If these are edges, write print_layers: [] into the part file");
  }
  const std::vector<std::string> left_out = leftOutTexts(selection);
  if (!left_out.empty()) text += "; what it has was left out: " + joined(left_out);
  throw std::runtime_error(text + ". " + remedyFor(selection));
}

void warnOfLineTypes(const EdgeSelection& selection, const std::vector<Stroke>& edges,
                     std::vector<std::string>* warnings) {
  for (const auto& [linetype, count] : selection.unknown_linetypes) {
    warnings->push_back(countText("line type " + linetype, count) +
                        " read as edges; the file does not define it");
  }
  std::map<std::string, std::size_t> kept;
  for (const Stroke& stroke : edges) {
    if (!stroke.annotation.empty()) ++kept["line type " + stroke.annotation];
  }
  for (const auto& [linetype, count] : kept)
    warnings->push_back(countText(linetype, count) + " read as edges, because of keep_layers");
}

/// A pose is that of the drawing's origin: far from it, a small error of its angle moves the part.
void warnOfDistance(const Contour& outer, std::vector<std::string>* warnings) {
  const double distance = boxOf(outer.points).exteriorDistance(Eigen::Vector2d::Zero().eval());
  if (distance <= kFarMm) return;
  warnings->push_back("the outline is " + number(std::round(1e-3 * distance)) +
                      " m from the drawing's origin, which is where the part's pose is given; move "
                      "it to the origin");
}

/// A file that states no unit, of a part that would be large in inches and is small in mm.
void warnOfSize(const DxfHeader& header, const std::string& told, const Contour& outer,
                std::vector<std::string>* warnings) {
  const double size = boxOf(outer.points).sizes().maxCoeff();
  if (!told.empty() || header.insunits.value_or(0) != 0 || size >= kSmallMm) return;
  warnings->push_back("the file states no unit ($INSUNITS): read as mm, the part is " +
                      number(size) +
                      " mm large; if it is drawn in inches, write units: inch into the part file");
}

/// A print beside the part is none: a title, or another part's.
void checkOnPart(const Contour& print, const Loop& outer) {
  const Eigen::AlignedBox2d box = boxOf(outer.points);
  for (const Eigen::Vector2d& p : print.points) {
    if (box.exteriorDistance(p) <= kMarginMm) continue;
    throw std::runtime_error("the print with " + nameOf(print) + " " + boxText(print.points) +
                             " is not on the part. List its layer in skip_layers");
  }
}

/// The edges of the part alone: without what is drawn twice, marks and slivers.
std::vector<Stroke> partEdges(EdgeSelection* selection, double tolerance) {
  CleanStrokes clean = cleanStrokes(selection->edges, tolerance);
  const auto leaveOut = [&](const std::string& reason, std::size_t count) {
    if (count > 0) selection->left_out[reason] += count;
  };
  leaveOut("drawn twice", clean.twice);
  leaveOut("shorter than the join tolerance", clean.slivers);
  for (const auto& [linetype, count] : dropLooseAnnotation(&clean.strokes, tolerance))
    leaveOut("line type " + linetype, count);
  leaveOut("centre marks", dropCentreMarks(&clean.strokes, tolerance));
  return std::move(clean.strokes);
}

std::vector<Contour> contoursOf(const std::vector<Stroke>& edges, double tolerance) {
  std::vector<Contour> contours = chainClosed(edges, tolerance);
  for (Contour& contour : contours) {
    const Eigen::Vector2d somewhere = contour.points.front();
    smooth(&contour, tolerance);
    if (contour.points.size() >= 3) continue;
    throw std::runtime_error("the contour with " + nameOf(contour) + " at " + inMm(somewhere) +
                             " encloses nothing. Delete it, or list its layer in skip_layers");
  }
  checkSize(contours);
  checkCrossings(contours);
  return contours;
}

void appendPrints(const EdgeSelection& selection, double tolerance, std::vector<Loop>* loops) {
  for (Contour& print : chainAny(cleanStrokes(selection.prints, tolerance).strokes, tolerance)) {
    smooth(&print, tolerance);
    checkOnPart(print, loops->front());
    loops->push_back({LoopKind::kPrint, print.closed, std::move(print.points)});
  }
}

Drawing assemble(const DxfFile& file, const DrawingParams& params) {
  Drawing drawing;
  const DrawingUnit unit = unitOf(file.header, params.units, &drawing.warnings);
  drawing.units = unit.name;
  const double scale = sheetScale(file, unit.mm, &drawing.warnings);
  EdgeSelection selection = selectEdges(file, params, scale * unit.mm);
  const double tolerance = params.join_tolerance_mm;
  const std::vector<Stroke> edges = partEdges(&selection, tolerance);
  if (edges.empty()) refuseNothingDrawn(selection);
  warnOfLineTypes(selection, edges, &drawing.warnings);
  const std::vector<Contour> contours = contoursOf(edges, tolerance);
  checkPassedOver(selection, contours, tolerance, &drawing.warnings);
  drawing.loops = classify(contours);
  const Contour outer{"", "", true, drawing.loops.front().points};
  warnOfSize(file.header, params.units, outer, &drawing.warnings);
  warnOfDistance(outer, &drawing.warnings);
  appendPrints(selection, tolerance, &drawing.loops);
  drawing.left_out = leftOutTexts(selection);
  for (Loop& loop : drawing.loops) {
    for (Eigen::Vector2d& p : loop.points) p *= 1e-3;
  }
  return drawing;
}

}  // namespace

Drawing loadDrawing(const std::string& path, const DrawingParams& params) {
  checkParams(params);
  const std::string content = readRegularFile(path, kBytesMax);
  try {
    return assemble(readDxf(content), params);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
}

}  // namespace planar_bin_picking
