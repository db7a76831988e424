// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Poses of one part in the picture that look alike, and the choice between them.
///
/// An outline looks nearly the same tilted the other way about the line of sight ([4]), turned or
/// flipped into a near-symmetry, and, where a print alone tells, into a symmetry. Each such pose is
/// a hypothesis, aligned by itself. One measure compares any two: the logarithm of the odds, the
/// sum of what outline, side wall, print and the way that the others lie say.

#include "locate/refine/aligner.h"

#include <optional>

namespace planar_bin_picking {

/// The likeliest pose of a part in the picture, and the one that competes with it by its tilt.
struct ChosenPose {
  PoseHypothesis pose;
  std::optional<PoseHypothesis> other_tilt;  ///< where it is another pose once aligned
  double lead = 0.0;  ///< log odds of pose over other_tilt, by outline, wall and print
  double odds = 0.0;  ///< the same with how the other parts lie; decideTilts
};

/// @param pose  aligned narrowly
ChosenPose chooseHypothesis(const Aligner& aligner, const RefineParams& params,
                            const PoseHypothesis& pose);

/// Parts rest on one another and on one floor, so how the others and the floor lie is evidence for
/// the sign of each tilt (scene_normals.h). Poses that change are aligned anew.
void decideTilts(const Aligner& aligner, const std::optional<Eigen::Vector3d>& floor_normal,
                 std::vector<ChosenPose>* poses);

/// RefinedPose::other_tilt.
/// @param decided  what the pose was refined from
Vector6d otherTiltOf(const Aligner& aligner, const ChosenPose& decided, const RefinedPose& pose);

}  // namespace planar_bin_picking
