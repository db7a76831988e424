// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/passed_over.h"

#include "base/polygon.h"
#include "drawing/dxf/dxf_names.h"
#include "drawing/part_contours.h"
#include "drawing/strokes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kRectangular = 0.999;     // of its box's area: but for rounding, a rectangle
constexpr std::size_t kLookedAtMax = 500;  // text in outlines has thousands, and is no hole

/// A closed contour that was left out, and by which rule.
struct LeftOutContour {
  Contour contour;
  const PassedOver* rule = nullptr;
  bool alone = true;  ///< nothing else was left out by the same rule

  std::string name() const { return (rule->by_line_type ? "line type " : "layer ") + rule->name; }
};

/// What was left out cannot refuse the part: if there is too much of it to look at, a warning says
/// so.
std::vector<LeftOutContour> closedContours(const EdgeSelection& selection, double tolerance,
                                           std::vector<std::string>* warnings) {
  std::map<std::pair<bool, std::string>, std::vector<const PassedOver*>> rules;
  for (const PassedOver& p : selection.passed_over) rules[{p.by_line_type, p.name}].push_back(&p);
  std::vector<LeftOutContour> closed;
  for (const auto& [key, members] : rules) {
    std::vector<Stroke> strokes;
    for (const PassedOver* p : members) strokes.push_back(p->stroke);
    std::vector<Contour> contours;
    try {
      contours = chainAny(cleanStrokes(strokes, tolerance).strokes, tolerance);
    } catch (const std::runtime_error& e) {
      warnings->push_back("layer or line type " + key.second + " was not searched for holes: it " +
                          e.what());
    }
    const auto left_out = selection.left_out.find("layer " + key.second);
    const bool alone = contours.size() == 1 && left_out != selection.left_out.end() &&
                       left_out->second <= members.size();
    for (Contour& contour : contours) {
      smooth(&contour, tolerance);
      if (contour.closed && contour.points.size() >= 3)
        closed.push_back({std::move(contour), members.front(), alone});
    }
  }
  std::stable_sort(closed.begin(), closed.end(), [](const auto& a, const auto& b) {
    return std::abs(signedArea(a.contour.points)) > std::abs(signedArea(b.contour.points));
  });
  return closed;
}

/// A sheet's frame, as title blocks have: a rectangle along the axes, on a layer that says so, that
/// is not all there is on it.
bool isFrame(const LeftOutContour& left_out) {
  if (left_out.rule->by_line_type || left_out.alone) return false;
  if (!matchesAny(left_out.rule->name, {"BORDER*", "TITLE*"})) return false;
  const Eigen::AlignedBox2d box = boxOf(left_out.contour.points);
  const double area = box.sizes().prod();
  return std::abs(signedArea(left_out.contour.points)) >= kRectangular * area;
}

bool holds(const Contour& outer, const std::vector<Contour>& contours) {
  return std::all_of(contours.begin(), contours.end(), [&](const Contour& inner) {
    return boxOf(outer.points).contains(boxOf(inner.points)) &&
           contains(outer.points, inner.points.front());
  });
}

/// Whether one of the contours lies in another: then none around them is the outline of one part.
bool areNested(const std::vector<Contour>& contours, const Contour& largest) {
  return std::any_of(contours.begin(), contours.end(), [&](const Contour& inner) {
    return &inner != &largest && contains(largest.points, inner.points.front());
  });
}

const Contour& largestOf(const std::vector<Contour>& contours) {
  return *std::max_element(contours.begin(), contours.end(),
                           [](const Contour& a, const Contour& b) {
                             return std::abs(signedArea(a.points)) < std::abs(signedArea(b.points));
                           });
}

[[noreturn]] void refuseOutline(const LeftOutContour& around) {
  const bool by_line_type = around.rule->by_line_type;
  throw std::runtime_error(
      around.name() + " has a closed contour " + boxText(around.contour.points) +
      " around all that is read as an edge; it was left out, because " +
      (by_line_type ? "this line type is annotation" : "layers called so are skipped by default") +
      ". If it is the part's outline, name its layer and those of the other edges in keep_layers; "
      "if it is not, " +
      (by_line_type ? "list its layer in skip_layers" : "name the part's layers in keep_layers"));
}

/// As a hole would: inside the outline, and apart from all holes.
bool mayBeHole(const Contour& candidate, const std::vector<Contour>& contours,
               const Contour& outer) {
  const Eigen::Vector2d& p = candidate.points.front();
  if (!contains(outer.points, p)) return false;
  for (const Contour& contour : contours) {
    if (!boxOf(contour.points).intersects(boxOf(candidate.points))) continue;
    if (&contour != &outer &&
        (contains(contour.points, p) || contains(candidate.points, contour.points.front())))
      return false;
    if (findCrossing({contour.points, candidate.points}, kExactMm)) return false;
  }
  return true;
}

}  // namespace

void checkPassedOver(const EdgeSelection& selection, const std::vector<Contour>& contours,
                     double tolerance, std::vector<std::string>* warnings) {
  const std::vector<LeftOutContour> closed = closedContours(selection, tolerance, warnings);
  const Contour& outer = largestOf(contours);
  const bool nested = areNested(contours, outer);
  std::map<std::string, std::size_t> holes;
  std::set<std::string> larger;
  for (std::size_t i = 0; i < std::min(closed.size(), kLookedAtMax); ++i) {
    const LeftOutContour& left_out = closed[i];
    if (holds(left_out.contour, contours)) {
      // Around a part with holes it is a frame, whatever it is called.
      if (nested) continue;
      if (left_out.rule->meaning == LineMeaning::kNeighbour || isFrame(left_out)) {
        larger.insert(left_out.name() + ": a closed contour " + boxText(left_out.contour.points) +
                      " around the part was left out");
        continue;
      }
      refuseOutline(left_out);
    }
    if (left_out.rule->by_line_type) continue;
    if (std::abs(signedArea(left_out.contour.points)) > std::abs(signedArea(outer.points))) {
      larger.insert(left_out.name() + ": a closed contour " + boxText(left_out.contour.points) +
                    ", larger than the part, was left out");
      continue;
    }
    if (mayBeHole(left_out.contour, contours, outer)) ++holes[left_out.name()];
  }
  warnings->insert(warnings->end(), larger.begin(), larger.end());
  for (const auto& [name, count] : holes) {
    warnings->push_back(name + ": " + std::to_string(count) +
                        (count == 1 ? " closed contour" : " closed contours") +
                        " inside the part left out by default; if these are holes, name all layers "
                        "of the part in keep_layers");
  }
}

}  // namespace planar_bin_picking
