// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part as the views see it: one face, its outline's points, and the edges of one picture.

#include "image/edge_map.h"
#include "image/edge_search.h"
#include "part/outline_view.h"
#include "planar_bin_picking/views/view.h"

#include <vector>

namespace planar_bin_picking {

/// What one looks for, made once per look.
struct SeenPart {
  SeenPart(const PartModel& model, Face face_up, const RefineParams& params)
      : part(&model),
        face(face_up),
        solid(solidOf(model, face_up)),
        T_part_centre(centreOf(model, face_up)),
        coarse(localPointsAt(model, shapeIndices(model, params.wide_points / 2))),
        fine(localPointsAt(model, shapeIndices(model, params.image_points))) {}

  const PartModel* part;
  Face face;
  Solid solid;
  Eigen::Isometry3d T_part_centre;
  std::vector<LocalPoint> coarse, fine;
};

/// The points with the edge offset `radii`.
inline std::vector<LocalPoint> inward(std::vector<LocalPoint> points, double radii) {
  moveInward(radii, &points);
  return points;
}

/// The view's picture as the edge search wants it; nothing is copied.
inline EdgeMap edgesOf(const View& view) {
  EdgeMap edges;
  edges.image = view.image();
  edges.noise = view.noise();
  return edges;
}

}  // namespace planar_bin_picking
