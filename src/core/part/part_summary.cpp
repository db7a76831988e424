// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/part_summary.h"

#include "base/polygon.h"
#include "base/yaml_text.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

std::string counted(std::size_t count, const std::string& thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

std::string symmetryText(const PartSummary& summary) {
  if (summary.symmetry_order == 0) return "round";
  const std::string fold = std::to_string(summary.symmetry_order) + "-fold";
  if (summary.symmetry_order == 1)
    return summary.mirror_symmetric ? "mirror symmetry" : "no symmetry";
  return fold + (summary.mirror_symmetric ? " and mirror symmetry" : " symmetry");
}

/// "layer DIM: 14 entities" as it reads within a sentence.
std::string withinLine(const std::string& left_out) {
  const std::size_t colon = left_out.rfind(": ");
  if (colon == std::string::npos) return left_out;
  return left_out.substr(0, colon) + " (" + left_out.substr(colon + 2) + ")";
}

}  // namespace

PartSummary describePart(const PartModel& part) {
  const PartFile& file = part.file();
  PartSummary summary;
  summary.part = part.name();
  summary.units = file.drawing.units;
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : file.drawing.loops.front().points) box.extend(p);
  summary.size_mm = 1e3 * box.sizes();
  for (const Loop& loop : file.drawing.loops) {
    if (loop.kind == LoopKind::kPrint) ++summary.prints;
    if (loop.kind == LoopKind::kHole) ++summary.holes;
    if (loop.kind == LoopKind::kPrint) continue;
    const double sign = loop.kind == LoopKind::kOuter ? 1e6 : -1e6;
    summary.area_mm2 += sign * std::abs(signedArea(loop.points));
  }
  summary.symmetry_order = part.symmetry().order;
  summary.mirror_symmetric = part.symmetry().mirror;
  for (const PickPose& pick : file.pick_poses) summary.pick_poses.push_back(pick.name);
  summary.left_out = file.drawing.left_out;
  summary.warnings = file.drawing.warnings;
  summary.warnings.insert(summary.warnings.end(), file.warnings.begin(), file.warnings.end());
  return summary;
}

std::string toYaml(const PartSummary& summary) {
  const auto line = [](const std::string& key, const std::string& value) {
    return key + ": " + value + "\n";
  };
  return line("part", yamlText(summary.part)) + line("units", yamlText(summary.units)) +
         line("size_mm", yamlList({summary.size_mm.x(), summary.size_mm.y()}, 3)) +
         line("area_mm2", yamlNumber(summary.area_mm2, 3)) +
         line("holes", std::to_string(summary.holes)) +
         line("prints", std::to_string(summary.prints)) +
         line("symmetry_order", std::to_string(summary.symmetry_order)) +
         line("mirror_symmetric", summary.mirror_symmetric ? "true" : "false") +
         line("pick_poses", yamlList(summary.pick_poses)) +
         line("left_out", yamlList(summary.left_out)) +
         line("warnings", yamlList(summary.warnings));
}

std::string toLine(const PartSummary& summary) {
  std::string text =
      yamlNumber(summary.size_mm.x(), 1) + " x " + yamlNumber(summary.size_mm.y(), 1) + " mm";
  if (!summary.units.empty() && summary.units != "mm") text += " (drawn in " + summary.units + ")";
  text += ", " + counted(summary.holes, "hole");
  if (summary.prints > 0) text += ", " + counted(summary.prints, "print");
  text += ", " + symmetryText(summary) + ", " + counted(summary.pick_poses.size(), "pick pose");
  for (std::size_t i = 0; i < summary.left_out.size(); ++i) {
    text += (i == 0 ? ", left out: " : ", ") + withinLine(summary.left_out[i]);
  }
  return text;
}

}  // namespace planar_bin_picking
