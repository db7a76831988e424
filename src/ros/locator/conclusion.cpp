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

}  // namespace

void conclude(const Look& look, Response* response) {
  if (!response->parts.empty()) {
    response->status = Response::OK;
    response->message = std::to_string(response->parts.size()) + " located";
  } else if (!response->refused.empty()) {
    response->status = Response::DEADLOCK;
    response->message = "none of " + std::to_string(response->refused.size()) +
                        " located parts can be offered: " + look.hint;
  } else {
    response->status = Response::NO_PART_FOUND;
    response->message = nothingFound(look.threshold, look.request, look.report);
  }
}

}  // namespace planar_bin_picking_ros
