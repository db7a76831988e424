// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What passes between the steps of stage 3.

#include "locate/align/field_points.h"
#include "locate/align/image_alignment.h"
#include "locate/refine/slides.h"
#include "part/outline_view.h"
#include "planar_bin_picking/part/part_model.h"

#include <array>
#include <memory>
#include <vector>

namespace planar_bin_picking {

/// A pose on its way from candidate to RefinedPose.
struct PoseHypothesis {
  std::size_t part = 0;
  Face face = Face::kFront;
  Eigen::Isometry3d T_camera_part = Eigen::Isometry3d::Identity();
  double inlier_score = 0.0;  ///< see inlier_score.h; in the field of fieldInlierScore
  ImagePose image;            ///< of this very pose; the default until it is aligned in the image
  bool searched = false;      ///< a search about this very pose found nothing better
};

/// Points of the outline where the edges of one face are seen.
struct FaceOutline {
  std::vector<LocalPoint> coarse, wide, fine;
  /// Metres by which the edges lie inside the drawn outline: the mean over the copies, its standard
  /// deviation, and that of one copy about it.
  double offset = 0.0, offset_sigma = 0.0, offset_spread = 0.0;
};

/// What the steps need of a part, made once per call.
struct PartOutline {
  const PartModel* part = nullptr;
  double grain = 0.0;  ///< see grainOf
  FieldPoints field;
  std::vector<LocalPoint> print;
  std::array<FaceOutline, 2> faces;  ///< by Face
  Slides slides;
  /// In the frame of the centre: where the line of sight may as well pass through the outline.
  std::vector<Eigen::Matrix2d> other_tilts;

  const FaceOutline& of(Face face) const { return faces[static_cast<int>(face)]; }
  FaceOutline& of(Face face) { return faces[static_cast<int>(face)]; }
};

}  // namespace planar_bin_picking
