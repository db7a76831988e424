// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 4: RefinedPose -> ScoredPose: the evidence for and against a pose, how probable it makes
/// the pose (probability.h), and how much of the part nothing covers (occlusion.h).
///
/// PoseEvidence::edges is the mean inlier score (Eq. 12 of [1], noise excluded, less with distance)
/// of outer contour, holes and print, each counting the same, holes by what the picture resolves of
/// them. Differs from [1] Sec. III-D, which averages over all points: holes are short but hardly
/// ever matched by chance (measured in test/benchmark).
/// Of the print only what is in view counts. Evidence against a pose lowers it, however well the
/// rest fits: a resolved hole that is clearly seen elsewhere or of another size (hole_evidence.h),
/// by a tenth a hole too many, and by half their share of the face in view edges that the drawing
/// does not have (flat_face.h). Edges that go on beyond corners (corner_evidence.h) and motions
/// that the picture does not hold enter the probability by themselves.

#include "image/edge_map.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/part/part_model.h"

#include <memory>
#include <vector>

namespace planar_bin_picking {

/// @return  as many as refined, in the same order
std::vector<ScoredPose> scorePoses(const EdgeMap& edges, const Camera& camera,
                                   const std::vector<std::shared_ptr<const PartModel>>& parts,
                                   const std::vector<RefinedPose>& refined,
                                   const ScoreParams& params, int threads);

}  // namespace planar_bin_picking
