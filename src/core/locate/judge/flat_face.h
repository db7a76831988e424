// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A posed part's face as if seen from straight above.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/part/face_grid.h"

#include <Eigen/Geometry>

namespace planar_bin_picking {

/// Where the camera sees a point of the face.
/// @param z  of the face in the part frame
inline Eigen::Vector2f pixelOnFace(const Camera& camera, const Eigen::Isometry3d& T_camera_part,
                                   const Eigen::Vector2d& point, double z) {
  return camera.project(T_camera_part * Eigen::Vector3d(point.x(), point.y(), z)).cast<float>();
}

/// Samples about the drawing's lines within which edges are its own.
inline constexpr float kOwnLines = 3.0f;

/// FaceGrid::kSamples to a cell's side.
struct FlatFace {
  cv::Mat_<std::uint8_t> grey;  ///< levels
  cv::Mat_<float> change;       ///< how fast they change, levels per sample
  std::vector<int> outside;     ///< cells whose middles lie outside the image, in order

  explicit FlatFace(const cv::Mat_<std::uint8_t>& levels);
};

/// @param z  of the face in the part frame
FlatFace flatten(const FaceGrid& grid, const cv::Mat& image, const Camera& camera,
                 const Eigen::Isometry3d& T_camera_part, double z);

/// Whether the face shows a closed edge where the drawing has none, as clear as its own, and within
/// it the same as through the drawn holes: a hole too many. A label, or what lies on the part,
/// looks otherwise.
/// @param covered  cells, in order; what covers the part may have holes of its own
/// @param holes    middles of the drawn holes, part frame
bool hasExtraHole(const FaceGrid& grid, const FlatFace& flat, const std::vector<int>& covered,
                  const std::vector<Eigen::Vector2d>& holes);

/// Share of the open face that edges take up which the drawing does not have, 0..1: hardly any on a
/// smooth part, more on a dirty or textured one, half of it where a pose lies over a heap of other
/// things. 0 where too little is open to tell.
/// @param covered  cells, in order
double foreignEdges(const FaceGrid& grid, const FlatFace& flat, const std::vector<int>& covered);

}  // namespace planar_bin_picking
