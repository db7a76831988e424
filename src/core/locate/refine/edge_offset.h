// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How far the edges are seen inside the drawn outline.
///
/// A bevelled, rounded or sheared cut shifts the edges of a copy all around, those of the two faces
/// by different amounts, and the light that a copy gets decides how far. One mean per part and
/// face, from all well aligned poses, unknown to 0.15 mm beforehand, and the spread of the copies
/// about it.

#include "locate/refine/pose_hypothesis.h"

namespace planar_bin_picking {

/// Estimates them anew; from then on the outlines are taken to lie at the means.
void estimateEdgeOffsets(const std::vector<PoseHypothesis>& poses,
                         std::vector<PartOutline>* outlines);

/// Logarithm of the density of a part's mean offset, metres, before anything is seen, but for a
/// constant.
double logOffsetPrior(double offset);

/// From then on the outline of the face is taken to lie there.
void setEdgeOffset(double offset, double sigma, double spread, Face face, PartOutline* outline);

/// The pose with the offset of its own edges as far as these tell it, else that of all copies, and
/// the covariance of both together.
RefinedPose withOwnOffset(const PoseHypothesis& pose, const PartOutline& outline, double focal_px);

}  // namespace planar_bin_picking
