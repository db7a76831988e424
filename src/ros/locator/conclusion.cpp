// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/conclusion.h"

#include <cstdio>

namespace planar_bin_picking_ros {

using planar_bin_picking::LocateRequest;
using Response = planar_bin_picking::LocatePart::Response;

namespace {

/// How many poses the plane ruled out.
std::size_t offPlane(const planar_bin_picking::Report& report) {
  const auto& stages = report.stages;
  for (std::size_t i = 1; i < stages.size(); ++i)
    if (stages[i].name == "plane") return stages[i - 1].out - stages[i].out;
  return 0;
}

std::string nothingFound(const double threshold, const LocateRequest& request,
                         const planar_bin_picking::Report& report) {
  char text[300];
  std::snprintf(text, sizeof text,
                "nothing scored %.2f or more between %.3f and %.3f m from the camera; if there are "
                "parts, look at ~overlay, check light, focus and these distances",
                threshold, request.distance_min, request.distance_max);
  const std::size_t off = offPlane(report);
  if (off == 0) return text;
  return text +
         ("; " + std::to_string(off) + " poses lay off the plane: check where it is said to " +
          "be, and the parts' thickness_mm");
}

/// Why NO_PART_FOUND is not EMPTY.
std::string notEmpty(const CellParams& cell, const planar_bin_picking::FloorCover& cover) {
  if (!cell.hasBin())
    return "; whether anything lies there cannot be told: ~cell/bin_frame, bin_min and bin_max "
           "would say where the bin is";
  if (!cover.doubt.empty()) return "; whether the bin is empty cannot be told: " + cover.doubt;
  char text[160];
  std::snprintf(text, sizeof text,
                "; something %.0f mm long lies on the bin's floor or is a mark of it, and %.0f %% "
                "of it are covered",
                1e3 * cover.longest, 1e2 * cover.covered);
  return text;
}

}  // namespace

void conclude(const Look& look, Response* response) {
  response->filling = look.cover.known() ? look.cover.covered : -1.0;
  if (!response->parts.empty()) {
    response->status = Response::OK;
    response->message = std::to_string(response->parts.size()) + " located";
  } else if (!response->refused.empty()) {
    response->status = Response::DEADLOCK;
    response->message = "none of " + std::to_string(response->refused.size()) +
                        " located parts can be offered: " + look.hint;
  } else if (look.cover.isEmpty(look.cell.empty_mark)) {
    response->status = Response::EMPTY;
    response->message = "the bin is empty: nothing was found, and its floor is bare";
  } else {
    response->status = Response::NO_PART_FOUND;
    response->message =
        nothingFound(look.threshold, look.request, look.report) + notEmpty(look.cell, look.cover);
  }
}

}  // namespace planar_bin_picking_ros
