// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Where in the picture or on the bin's floor parts may lie, where that is less than the camera or
/// the bin shows: a box or a polygon. A part belongs to it where the centre of its visible face
/// does.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locate_request.h"

#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// Corners in their order, either way round; empty = everywhere.
using RegionOutline = std::vector<Eigen::Vector2d>;

struct Region {
  RegionOutline pixels;  ///< of the picture
  RegionOutline metres;  ///< x and y of the region's frame, at any height

  bool isEverywhere() const { return pixels.empty() && metres.empty(); }
};

/// @param numbers  x, y, x, y, ...: two points are opposite corners of a box, more a polygon
/// @throws std::invalid_argument  what is wrong: an odd count, less than two points, what is no
///         number, an outline without area or one that crosses itself
RegionOutline regionOutline(const std::vector<double>& numbers);
/// The same of points; three at least.
RegionOutline regionOutline(RegionOutline points);

/// Whether a point lies within; true everywhere where there is no outline.
bool isWithin(const RegionOutline& outline, const Eigen::Vector2d& point);

/// Why a point in front of the camera lies outside of the region; nothing where it lies within.
std::optional<std::string> outsideOf(const Region& region, const Camera& camera,
                                     const Eigen::Isometry3d& T_region_camera,
                                     const Eigen::Vector3d& p_camera);

/// What of the picture parts can reach whose centre lies within the region.
/// @param distances  of the parts, along the optical axis
/// @param reach      metres from a part's centre to its farthest point, and what is to be seen
///                   about it
/// @return  nothing where it is the whole picture, or nothing in front of the camera
std::optional<PixelBox> windowOf(const Region& region, const Camera& camera,
                                 const Eigen::Isometry3d& T_region_camera,
                                 const Distances& distances, double reach);

/// What was taught: an outline in metres and its frame.
struct RegionFile {
  std::string frame;
  RegionOutline metres;
};

/// Replaces the file.
/// @throws std::runtime_error  the path and the system's reason
void saveRegion(const std::string& path, const RegionFile& region);

/// @return  nothing where there is no such file
/// @throws std::runtime_error  it cannot be read: path, key and what is wrong
std::optional<RegionFile> loadRegion(const std::string& path);

}  // namespace planar_bin_picking
