// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/part_size.h"

#include "part/part_extent.h"
#include "planar_bin_picking/locate/locate_request.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

namespace planar_bin_picking {
namespace {

/// Size of what the camera sees one metre away, metres.
Eigen::Vector2d viewOf(const Camera& camera) {
  const Camera::Model& m = camera.model();
  const double right = m.width - 0.5, bottom = m.height - 0.5;
  return {camera.undistort({right, m.cy}).x() - camera.undistort({-0.5, m.cy}).x(),
          camera.undistort({m.cx, bottom}).y() - camera.undistort({m.cx, -0.5}).y()};
}

/// Whether enough of a rectangle lies inside the view at some turn.
bool fits(const Extent& extent, const Eigen::Vector2d& view) {
  constexpr int kTurns = 90;  // of a quarter turn: steps of one degree
  for (int i = 0; i <= kTurns; ++i) {
    const double turn = 0.5 * EIGEN_PI * i / kTurns, c = std::cos(turn), s = std::sin(turn);
    if (kInViewShare * (extent.length * c + extent.width * s) <= view.x() &&
        kInViewShare * (extent.length * s + extent.width * c) <= view.y()) {
      return true;
    }
  }
  return false;
}

std::string text(const PartModel& part, const Extent& extent, double focal_px, double distance,
                 const Distances& asked, const std::string& why) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(4);
  out << "part " << part.name() << " is " << 1e3 * extent.length << " x " << 1e3 * extent.width
      << " mm, that is " << std::round(focal_px * extent.length / distance) << " x "
      << std::round(focal_px * extent.width / distance) << " pixels at " << distance
      << " m (distances " << asked.min << " .. " << asked.max << " m): " << why
      << ". Is its drawing in another unit? Then say so in the part's file, such as units: inch. "
         "Else change the distances or take another camera or lens";
  return out.str();
}

}  // namespace

void checkPartSize(const PartModel& part, const Camera& camera, double distance_min,
                   double distance_max) {
  checkDistances(distance_min, distance_max);
  const Extent extent = extentOf(part);
  const Camera::Model& m = camera.model();
  const double focal_px = std::min(m.fx, m.fy);
  const Distances asked{distance_min, distance_max};
  // At the near end: a range may well reach farther than a part is seen; a wrong unit is wrong all
  // over it. Poses at which a part is too small are withheld one by one.
  if (farthestSeen(extent, focal_px) < distance_min) {
    std::ostringstream least;
    least << "too small; at least " << kLeastLengthPx << " x " << kLeastWidthPx
          << " pixels tell a part from chance";
    throw PartSizeError(text(part, extent, focal_px, distance_min, asked, least.str()));
  }
  if (!fits(extent, distance_max * viewOf(camera))) {
    std::ostringstream view;
    view << "it does not fit into the view of " << m.width << " x " << m.height << " pixels";
    throw PartSizeError(text(part, extent, focal_px, distance_max, asked, view.str()));
  }
}

}  // namespace planar_bin_picking
