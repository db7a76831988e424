// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Stage 3: candidate -> RefinedPose, coarse to fine.

#include "image/edge_map.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/part/part_model.h"

#include <memory>
#include <optional>
#include <vector>

namespace planar_bin_picking {

/// @param parts       those that Candidate::part indexes
/// @param floor_normal  as LocateRequest::floor_normal
/// @param overlap_max   as RankParams::overlap_max: what the rank would leave out is not refined
/// @return            poses without duplicates, highest inlier score first
std::vector<RefinedPose> refineCandidates(
    const EdgeMap& edges, const Camera& camera,
    const std::vector<std::shared_ptr<const PartModel>>& parts,
    const std::vector<Candidate>& candidates, const std::optional<Eigen::Vector3d>& floor_normal,
    double overlap_max, const RefineParams& params, int threads);

}  // namespace planar_bin_picking
