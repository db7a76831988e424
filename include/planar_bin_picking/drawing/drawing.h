// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The contours of a flat part, and which layers of a drawing they stand on.

#include "planar_bin_picking/base/types.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

enum class LoopKind : std::uint8_t { kOuter, kHole, kPrint };

/// One contour as a polyline in the part frame.
struct Loop {
  LoopKind kind = LoopKind::kOuter;
  bool closed = true;  ///< the last point joins the first (it is not repeated)
  /// Metres. Outer loops run counter-clockwise, holes clockwise: the material is on the left.
  std::vector<Eigen::Vector2d> points;
};

double lengthOf(const Loop& loop);  ///< metres

/// The contours of one flat part: exactly one outer loop, then holes, then prints.
struct Drawing {
  std::vector<Loop> loops;
  std::string units = "mm";           ///< of the file, as read or as told
  std::vector<std::string> left_out;  ///< such as "layer DIM: 14 entities"; in the alphabet's order
  std::vector<std::string> warnings;  ///< what its user should look at
};

/// Which layers of a drawing are edges. Patterns are matched without case; `*` stands for anything.
struct DrawingParams {
  /// If not empty, only these are read, whatever their line types.
  std::vector<std::string> keep_layers;
  std::vector<std::string> skip_layers = {"DIM*",  "CENTER*", "TITLE*",
                                          "TEXT*", "BORDER*", "DEFPOINTS"};
  /// Front face only.
  std::vector<std::string> print_layers = {
      "PRINT*",   "SILK*",      "*ENGRAV*",    "ETCH*",       "GRAVIR*",      "GRAV\u00cdR*",
      "GRAVUR*",  "GRAVIER*",   "GRAVER*",     "GRAVAD*",     "GRAVA\u00c7*", "GRAWER*",
      "INCIS*",   "MARKING*",   "MARKIER*",    "MARQUAGE*",   "BESCHRIFT*",   "SCRIB*",
      "GRABADO*", "LASERMARK*", "LASER-MARK*", "LASER_MARK*", "LASER MARK*"};
  double chord_tolerance_mm = 0.01;  ///< curves become chords that stay this close to them
  double join_tolerance_mm = 0.05;   ///< end points closer than this belong together
  std::string units;                 ///< mm, cm, m, inch or ft, in place of what the file says
};

}  // namespace planar_bin_picking
