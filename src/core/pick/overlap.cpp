// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/overlap.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kEdgeOn = 0.2;  // cosine; a part that stands so upright has no top to speak of

// Of its thickness that the upper part has to be above the lower one's face; it is by all of it.
constexpr double kAbove = 0.5;

/// The cell of the face that holds the point; -1 where there is none.
int cellAt(const FaceGrid& grid, const Eigen::Vector2d& p) {
  const int cell = grid.cellNear(p);
  if (cell < 0) return -1;
  const Eigen::Vector2d off = grid.cells()[static_cast<std::size_t>(cell)] - p;
  return off.cwiseAbs().maxCoeff() <= 0.5 * grid.cellSize() ? cell : -1;
}

}  // namespace

std::vector<int> cellsBelow(const LyingFace& own, const LyingFace& other) {
  const Eigen::Isometry3d T_other_own = other.T_target_part.inverse() * own.T_target_part;
  const double z = own.part->faceZ(own.face);
  const auto middleOf = [](const PartModel& part, double at) {
    return Eigen::Vector3d(part.center().x(), part.center().y(), at);
  };
  const double apart = (T_other_own * middleOf(*own.part, z) - middleOf(*other.part, 0.0)).norm();
  if (apart > own.part->radius() + other.part->radius() + other.part->thickness()) return {};
  const Eigen::Vector3d up = T_other_own.linear().col(2) * (own.face == Face::kFront ? 1.0 : -1.0);
  if (std::abs(up.z()) < kEdgeOn) return {};
  const FaceGrid& grid = other.part->faceGrid();
  std::vector<bool> is_covered(grid.cells().size(), false);
  for (const Eigen::Vector2d& p : other.covered) {
    const int cell = cellAt(grid, p);
    if (cell >= 0) is_covered[static_cast<std::size_t>(cell)] = true;
  }
  const double thickness = other.part->thickness();
  std::vector<int> below;
  const auto& cells = own.part->faceGrid().cells();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Eigen::Vector3d point = T_other_own * Eigen::Vector3d(cells[i].x(), cells[i].y(), z);
    // Up from there to its upper face.
    const double height = std::max(-point.z() / up.z(), (-thickness - point.z()) / up.z());
    if (!(height > kAbove * thickness)) continue;
    const int cell = cellAt(grid, (point + height * up).head<2>());
    if (cell >= 0 && !is_covered[static_cast<std::size_t>(cell)])
      below.push_back(static_cast<int>(i));
  }
  return below;
}

}  // namespace planar_bin_picking
