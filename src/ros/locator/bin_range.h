// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A cell's bin as the camera sees it: how near and how far it reaches, and how much lies in it.

#include "locator/answer/answer.h"
#include "locator/bin/bin_finder.h"
#include "locator/settings/cell_params.h"
#include "planar_bin_picking/bin/floor_cover.h"
#include "planar_bin_picking/bin/region.h"

#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace planar_bin_picking_ros {

/// What the search for the bin's rim goes by.
BinFinder::Settings binSettings(const CellParams& cell);

/// T_told_found: the bin as ~locate_bin found it, from where its frame is.
Eigen::Isometry3d foundBin(const CellParams& cell);
/// As the cell's parameters have it; empty for the identity.
std::vector<double> foundBin(const Eigen::Isometry3d& T_told_found);

/// The bin's inner space from above, bin frame.
planar_bin_picking::RegionOutline floorOf(const CellParams& cell);

struct DistanceRange {
  double min = 0.0, max = 0.0;  ///< metres
};

/// @param T_camera_bin  at the image's stamp
/// @throws Refusal  BAD_BIN: a corner lies beside or behind the camera, or the box reaches nearer,
///         farther or over a larger ratio of distances than parts can be looked for in
DistanceRange distanceRange(const CellParams& cell, const Eigen::Isometry3d& T_camera_bin);

/// @return  of the bin's floor, camera frame, toward the camera whichever way the frame's z points
Eigen::Vector3d floorNormal(const CellParams& cell, const Eigen::Isometry3d& T_camera_bin);

/// How much of the bin's floor is covered in the picture of an answer, by whatever it is.
/// @param answer  with all that was found in it
planar_bin_picking::FloorCover lookIntoBin(const CellParams& cell,
                                           const Eigen::Isometry3d& T_camera_bin,
                                           const Answer& answer);

/// The region in force as one picture has it.
struct SeenRegion {
  planar_bin_picking::Region region;
  Eigen::Isometry3d T_region_camera = Eigen::Isometry3d::Identity();
};

/// What of the picture has to be looked at for parts within the region; nothing = all of it.
/// @param request  its parts and distances
std::optional<planar_bin_picking::PixelBox> windowOf(
    const SeenRegion& region, const planar_bin_picking::Camera& camera,
    const planar_bin_picking::LocateRequest& request);

/// Withholds what lies outside of the region.
void keepWithin(const SeenRegion& region, Answer* answer);

/// Bin and region, to be drawn into the answer's picture.
/// @param T_camera_bin     nothing: the cell names no bin
void addOutlines(const CellParams& cell, const std::optional<Eigen::Isometry3d>& T_camera_bin,
                 const SeenRegion& region, Answer* answer);

}  // namespace planar_bin_picking_ros
