// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What was read of a part, for people: a drawing in the wrong unit, a hole on a skipped layer or a
/// missing pick pose shows here, before a robot moves.

#include "planar_bin_picking/part/part_model.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

struct PartSummary {
  std::string part;
  std::string units;                                  ///< of the drawing's lengths
  Eigen::Vector2d size_mm = Eigen::Vector2d::Zero();  ///< of the bounding box
  double area_mm2 = 0.0;                              ///< holes subtracted
  int holes = 0, prints = 0;
  int symmetry_order = 1;  ///< of the outline; 0 = full circle
  bool mirror_symmetric = false;
  std::vector<std::string> pick_poses;  ///< names, as the part file has them
  std::vector<std::string> left_out;    ///< of the drawing: "layer DIM: 14 entities"
  std::vector<std::string> warnings;    ///< of the drawing, then of the part file
};

PartSummary describePart(const PartModel& part);

/// One YAML map, a line per field, in the order of the fields.
std::string toYaml(const PartSummary& summary);

/// One line without the name and the warnings, for a log: "90.0 x 60.0 mm, 2 holes, no symmetry, 2
/// pick poses, left out: layer DIM (14 entities)".
std::string toLine(const PartSummary& summary);

}  // namespace planar_bin_picking
