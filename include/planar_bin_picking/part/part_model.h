// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part prepared for the stages: outline samples, symmetry and everything else that depends on
/// the drawing alone. Made once per part, immutable, shared.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/drawing/symmetry.h"
#include "planar_bin_picking/part/face_grid.h"
#include "planar_bin_picking/part/near_symmetry.h"
#include "planar_bin_picking/part/outline.h"
#include "planar_bin_picking/part/part_file.h"
#include "planar_bin_picking/part/pick_poses.h"

#include <memory>
#include <string>
#include <vector>

namespace planar_bin_picking {

class PartModel {
 public:
  /// @throws std::invalid_argument  an outline without an outer loop, a negative thickness
  explicit PartModel(PartFile file);

  const std::string& name() const { return file_.name; }
  const PartFile& file() const { return file_; }
  const Symmetry& symmetry() const { return symmetry_; }
  double thickness() const { return file_.thickness; }
  double radius() const { return radius_; }  ///< of the circle about center(), metres
  const Eigen::Vector2d& center() const { return center_; }  ///< of the bounding box
  /// Those of the file with their symmetric copies, see withSymmetricCopies.
  const std::vector<PickPose>& pickPoses() const { return pick_poses_; }
  bool hasPrint() const { return has_print_; }
  /// Evenly spaced along all loops, loop by loop, in order; prints at the end.
  const std::vector<OutlinePoint>& outline() const { return outline_; }
  const FaceGrid& faceGrid() const { return face_grid_; }
  const std::vector<NearSymmetry>& nearSymmetries() const { return near_symmetries_; }
  /// Order of the rotations after which the shape is all but the same (a sprocket's teeth): voting
  /// need not tell these apart. 0 = full circle; at least symmetry().order.
  int nearOrder() const { return near_order_; }
  /// z of a face in the part frame: 0 for the front, -thickness for the back.
  double faceZ(Face face) const { return face == Face::kFront ? 0.0 : -thickness(); }

 private:
  PartFile file_;
  Symmetry symmetry_;
  Eigen::Vector2d center_ = Eigen::Vector2d::Zero();
  double radius_ = 0.0;
  bool has_print_ = false;
  std::vector<PickPose> pick_poses_;
  std::vector<OutlinePoint> outline_;
  FaceGrid face_grid_;
  std::vector<NearSymmetry> near_symmetries_;
  int near_order_ = 1;
};

using PartPtr = std::shared_ptr<const PartModel>;

/// One of them is set.
struct LoadedPart {
  PartPtr part;
  std::string error;  ///< why there is none
};

/// Reads many parts on all cores. @return  one for each path, in their order
/// Cost: 5 ms for a part of 100 lines and arcs, on one core; test/benchmark/parts.py
std::vector<LoadedPart> loadParts(const std::vector<std::string>& paths);

}  // namespace planar_bin_picking
