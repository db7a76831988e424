// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Moves hypotheses of a pose onto the edges of one picture, coarse to fine.

#include "locate/refine/pose_hypothesis.h"
#include "planar_bin_picking/locate/params.h"

#include <optional>

namespace planar_bin_picking {

class Aligner {
 public:
  Aligner(const EdgeMap& edges, const Camera& camera, const RefineParams& params,
          const std::vector<std::shared_ptr<const PartModel>>& parts);

  /// Coarse refinement in the distance field.
  PoseHypothesis alignToField(const Candidate& candidate) const;
  /// In the image, from what the field leaves (a small share of the part's size) to within the
  /// narrow reach. No covariance: a narrow alignment follows.
  void alignWide(PoseHypothesis* pose) const;
  void alignNarrow(PoseHypothesis* pose) const;
  /// Twice: from so far the first time often ends halfway.
  void alignNarrowFromAfar(PoseHypothesis* pose) const;
  /// What the edges found by a narrow alignment say of the pose where it is.
  void look(PoseHypothesis* pose) const;
  /// Restarts about an aligned pose, since one side of the outline may have been aligned to a
  /// neighbour's edge or a shadow: farther and nearer ([1] Sec. III-E goes farther only), tilted to
  /// all sides. Does nothing where the last search found nothing better.
  void searchAround(PoseHypothesis* pose) const;

  /// Of these points of the outline, in the image and in the field.
  double inlierScoreOf(const PoseHypothesis& pose, const std::vector<LocalPoint>& points) const;
  double fieldInlierScoreOf(const PoseHypothesis& pose,
                            const std::vector<LocalPoint>& points) const;
  /// Of the side walls' lower edges, see wall_evidence.h.
  std::optional<double> wallScoreOf(const PoseHypothesis& pose) const;
  /// How much more of the narrow side walls is seen where a pose has them than where another one
  /// has, see wall_bands.h.
  double wallBandsOf(const PoseHypothesis& pose, const PoseHypothesis& other) const;
  /// Of the print as it would be seen from the front, see print_evidence.h.
  double printScoreOf(const PoseHypothesis& pose) const;

  const std::vector<PartOutline>& outlines() const { return outlines_; }
  std::vector<PartOutline>& outlines() { return outlines_; }
  const PartOutline& outlineOf(const PoseHypothesis& pose) const { return outlines_[pose.part]; }
  const EdgeMap& edges() const { return edges_; }
  const Camera& camera() const { return camera_; }
  double focal() const { return camera_.model().fx; }  ///< pixels

 private:
  int wideReach(const PoseHypothesis& pose) const;
  PoseHypothesis alignInFieldFrom(const Eigen::Isometry3d& T_camera_centre, std::size_t part,
                                  Face face, double reach_radii) const;
  /// Where a search begins, T_camera_centre.
  std::vector<Eigen::Isometry3d> startsAround(const PoseHypothesis& pose) const;
  /// Starts along the slides of the outline and of its near-symmetries, the best first.
  std::vector<SlidPose> slidesOf(const PoseHypothesis& pose) const;
  /// Steps in the raw image, one for each width of the kernel.
  template <std::size_t N>
  ImagePose steps(const std::vector<LocalPoint>& points, const SearchProfile& profile,
                  const std::array<double, N>& tukey_px, const Solid& solid,
                  const Eigen::Isometry3d& T_camera_centre) const;
  /// The pose as the image has it, with its inlier score.
  void set(const ImagePose& image, const std::vector<LocalPoint>& points,
           PoseHypothesis* pose) const;

  const EdgeMap& edges_;
  const Camera& camera_;
  const RefineParams& params_;
  std::vector<PartOutline> outlines_;
};

}  // namespace planar_bin_picking
