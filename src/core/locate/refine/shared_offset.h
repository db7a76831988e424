// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The edge offset and the tilts of slender parts, which only all copies together tell apart.
///
/// Each copy alone lies at any of many tilts, each with another offset (tilt_curve.h). But the
/// copies share bevel and light, hence nearly one offset, and many of them lie as most parts of the
/// picture do. Too large an offset no tilt makes up for, as the cosine is one at most; too small a
/// one would tilt every copy. So offset, its spread and the tilts are estimated together, on grids,
/// and each tilt is stated as wide as it remains.

#include "locate/refine/aligner.h"

#include <vector>

namespace planar_bin_picking {

/// Estimates them; from then on the outlines of slender parts lie at their offset. The poses of
/// other parts tell how parts lie, and do not change.
/// @param poses  aligned narrowly
/// Cost: nothing where no part is slender, else 2 ms for each copy.
void shareOffsets(Aligner* aligner, std::vector<PoseHypothesis>* poses, int threads);

}  // namespace planar_bin_picking
