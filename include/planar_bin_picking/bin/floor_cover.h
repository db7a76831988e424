// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Whether anything lies on a bin's floor, whatever it is: an empty bin apart from a bin in which
/// nothing was found.
///
/// The part of the picture that shows the floor is laid out flat, as seen from straight above. An
/// edge there is something that lies on the floor, or a mark of the floor itself; nobody can tell
/// which. What edges touch or surround counts as covered. So an empty floor that is plain, however
/// grainy, is told from one on which something lies; one with ribs, seams, prints or hard shadows
/// never passes for empty. In doubt there is something.

#include "planar_bin_picking/image/camera.h"

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <string>
#include <vector>

namespace planar_bin_picking {

/// The bin's inner space as a box of its own frame; min.z is the floor, and one looks in at max.z.
struct BinBox {
  Eigen::Isometry3d T_camera_bin = Eigen::Isometry3d::Identity();
  Eigen::Vector3d min = Eigen::Vector3d::Zero(), max = Eigen::Vector3d::Zero();  ///< metres
};

struct FloorCover {
  /// Share of the floor in view that located parts hide, or that edges touch or surround, 0..1. A
  /// lower bound: the middle of another part that leans on a wall counts as floor. Negative: not
  /// known.
  double covered = -1.0;
  double longest = 0.0;  ///< metres; the longest diagonal of edges that hang together
  /// Why the picture cannot say that the floor is empty; "" where it can.
  std::string doubt;

  bool known() const { return covered >= 0.0; }
  /// @param mark  metres; what is shorter may belong to the floor: scratches, grit
  bool isEmpty(double mark) const { return known() && doubt.empty() && longest < mark; }
};

/// @param image    8- or 16-bit, one channel, of the camera's size
/// @param located  outlines of what was located, camera frame: it covers the floor, too
/// Cost: some 10 ms.
FloorCover findFloorCover(const cv::Mat& image, const Camera& camera, const BinBox& bin,
                          const std::vector<std::vector<Eigen::Vector3d>>& located = {});

}  // namespace planar_bin_picking
