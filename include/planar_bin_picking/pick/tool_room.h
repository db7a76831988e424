// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A tool of several bodies, such as two fingers or four cups, and whether it has room at a pick
/// pose: fingers that reach beside a part must find nothing there.
///
/// Tool frame: that of the pick pose, origin at the contact, z into the part. What is above the
/// contact has z < 0; fingers beside the part reach to z > 0.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/part/part_model.h"

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// An upright prism.
struct ToolBody {
  std::vector<Eigen::Vector2d> footprint;  ///< convex, counter-clockwise, metres
  double low = 0.0, high = 0.0;            ///< along z, metres
};

/// @param boxes      x, y, z and x, y, z of two opposite corners, box after box
/// @param cylinders  x, y, radius, z, z, one after the other; along the tool's z
/// @throws std::invalid_argument  key, and what is wrong with its numbers
std::vector<ToolBody> toolBodies(const std::vector<double>& boxes,
                                 const std::vector<double>& cylinders);

/// The bin's inner space as a box; tools come and go through its top.
struct PickBin {
  Eigen::Isometry3d T_bin_target = Eigen::Isometry3d::Identity();
  Eigen::Vector3d min = Eigen::Vector3d::Zero(), max = Eigen::Vector3d::Zero();  ///< bin frame
};

/// A part that lies somewhere.
struct LyingPart {
  std::shared_ptr<const PartModel> part;
  Eigen::Isometry3d T_target_part = Eigen::Isometry3d::Identity();
};

/// Where the tool goes, and from where.
struct ToolWay {
  const std::vector<ToolBody>& bodies;
  Eigen::Isometry3d T_target_pick;
  double approach = 0.0;   ///< metres, against z
  double clearance = 0.0;  ///< metres, to all sides
};

/// Whether the tool touches a wall or the floor of the bin on its way.
bool touchesBin(const ToolWay& way, const PickBin& bin);

/// Whether it touches a part on its way. One of unknown thickness is taken for a thin sheet.
bool touchesPart(const ToolWay& way, const LyingPart& other);

/// Whether bodies that reach beside the part do not leave the part itself free: fingers that are
/// opened too little for it, or turned the wrong way. Cups and magnets that end at its face, or up
/// to 1.5 mm below it, do not count: they are pressed on.
/// @param T_part_pick  as the part's file has it
bool touchesOwnPart(const std::vector<ToolBody>& bodies, const PartModel& part,
                    const Eigen::Isometry3d& T_part_pick);

/// Edges in a picture that none of the located parts explains: something else may lie there.
class StrangeEdges {
 public:
  struct Seen {
    std::shared_ptr<const PartModel> part;
    Eigen::Isometry3d T_camera_part = Eigen::Isometry3d::Identity();
  };

  /// @param image  8- or 16-bit, one channel, of the camera's size
  /// Cost: that of finding edges, some 50 ms.
  StrangeEdges(const cv::Mat& image, const Camera& camera, const std::vector<Seen>& parts);

  /// Metres of such edges where the tool comes down; below bodies that end more than 30 mm above
  /// the contact nothing is looked for.
  double below(const std::vector<ToolBody>& bodies, const Eigen::Isometry3d& T_camera_pick) const;

 private:
  cv::Mat edges_;  ///< 8 bit; not 0 on an edge. Of an undistorted picture:
  double focal_ = 0.0, cx_ = 0.0, cy_ = 0.0;
};

}  // namespace planar_bin_picking
