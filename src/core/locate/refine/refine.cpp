// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/refine.h"

#include "base/parallel.h"
#include "locate/refine/aligner.h"
#include "locate/refine/edge_offset.h"
#include "locate/refine/hypotheses.h"
#include "locate/refine/shared_offset.h"
#include "locate/refine/suppression.h"
#include "part/visible_face.h"

namespace planar_bin_picking {
namespace {

/// Radii within which two poses are one: what the alignment in the field leaves, and that in the
/// image (4 and 2 pixels for a radius of 100).
constexpr double kSameInField = 0.04, kSameInImage = 0.02;
constexpr int kSearchRounds = 2;  // the second starts at what the first has found
constexpr double kAligned = 0.7;  // inlier scores above tell where edges lie (edge_offset.cpp)

/// Whether enough edges determine the pose, and the camera can see the face that it says is up.
bool isDetermined(const PoseHypothesis& pose, const PartOutline& outline) {
  return pose.image.status == AlignmentStatus::kAligned &&
         showsFace(*outline.part, pose.T_camera_part, pose.face);
}

}  // namespace

std::vector<RefinedPose> refineCandidates(
    const EdgeMap& edges, const Camera& camera,
    const std::vector<std::shared_ptr<const PartModel>>& parts,
    const std::vector<Candidate>& candidates, const std::optional<Eigen::Vector3d>& floor_normal,
    double overlap_max, const RefineParams& params, int threads) {
  Aligner aligner(edges, camera, params, parts);
  std::vector<PoseHypothesis> poses(candidates.size());
  const auto forAll = [&](auto&& step) {
    parallelFor(static_cast<int>(poses.size()), threads, [&](int i) { step(&poses[i], i); });
  };
  const auto suppress = [&](double distance, double score_min, int least = 0) {
    keepOnly(withoutDuplicates(poses, aligner.outlines(), distance, score_min,
                               {least, params.max_poses}),
             &poses);
  };
  const auto suppressOutscored = [&] {
    keepOnly(withoutOutscored(poses, aligner.outlines(), overlap_max), &poses);
  };

  forAll([&](auto* p, int i) { *p = aligner.alignToField(candidates[i]); });
  suppress(kSameInField, params.field_inliers_min, params.min_poses);
  forAll([&](auto* p, int) { aligner.alignWide(p); });
  suppress(kSameInImage, params.image_inliers_min);
  suppressOutscored();
  forAll([&](auto* p, int) {
    if (p->inlier_score > kAligned) aligner.alignNarrow(p);
  });
  estimateEdgeOffsets(poses, &aligner.outlines());
  for (int round = 0; round < kSearchRounds; ++round) {
    forAll([&](auto* p, int) { aligner.searchAround(p); });
    suppress(kSameInImage, params.search_inliers_min);
    suppressOutscored();
  }

  std::vector<ChosenPose> chosen(poses.size());
  forAll([&](auto* p, int i) {
    aligner.alignNarrow(p);
    chosen[i] = chooseHypothesis(aligner, params, *p);
    *p = chosen[i].pose;
  });
  keepOnly(withoutDuplicates(poses, aligner.outlines(), kSameInImage, params.search_inliers_min,
                             {0, params.max_poses}),
           &chosen);
  decideTilts(aligner, floor_normal, &chosen);
  poses.clear();
  for (const auto& c : chosen) poses.push_back(c.pose);
  estimateEdgeOffsets(poses, &aligner.outlines());
  forAll([&](auto* p, int) { aligner.alignNarrow(p); });
  shareOffsets(&aligner, &poses, threads);

  std::vector<RefinedPose> out;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const PartOutline& outline = aligner.outlineOf(poses[i]);
    if (!isDetermined(poses[i], outline)) continue;
    out.push_back(withOwnOffset(poses[i], outline, aligner.focal()));
    out.back().other_tilt = otherTiltOf(aligner, chosen[i], out.back());
  }
  return out;
}

}  // namespace planar_bin_picking
