// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pick_neighbours.h"

#include "polygon.h"

#include <algorithm>

namespace planar_bin_picking {
namespace {

constexpr double kRim = 0.002;  // metres beside a contour that may still touch it
constexpr double kShare =
    0.5;  // of a part's thickness by which its face is higher if it lies on another
constexpr double kLeastOver = 0.001;  // metres, the same of parts whose thickness is not known

double higherBy(const PickFace& upper) { return std::max(kLeastOver, kShare * upper.thickness); }

/// In a face's frame: x and y as in the part's, z = height over the face.
Eigen::Vector3d inFace(const PickFace& face, const Eigen::Vector3d& x_target) {
  const Eigen::Vector3d x_part = face.T_target_part.inverse() * x_target;
  return {x_part.x(), x_part.y(), face.up * (x_part.z() - face.z)};
}

/// Whether a point lies in the contour, or no farther beside it than `reach`.
bool isWithin(const Polygon& contour, const Eigen::Vector2d& point, double reach) {
  if (contour.size() < 3) return false;
  if (contains(contour, point)) return true;
  for (std::size_t i = 0; i < contour.size(); ++i)
    if (distanceToSegment(point, contour[i], contour[(i + 1) % contour.size()]) <= reach)
      return true;
  return false;
}

}  // namespace

bool liesOn(const PickFace& upper, const PickFace& lower) {
  return std::any_of(upper.contour.begin(), upper.contour.end(), [&](const Eigen::Vector2d& p) {
    const Eigen::Vector3d x =
        inFace(lower, upper.T_target_part * Eigen::Vector3d(p.x(), p.y(), upper.z));
    return x.z() > higherBy(upper) && isWithin(lower.contour, x.head<2>(), kRim);
  });
}

bool isOver(const PickFace& upper, const PickFace& lower, const Eigen::Isometry3d& T_target_pick,
            double radius) {
  // The tool's own height over the face does not count: it may dip into it or stop above.
  const Eigen::Vector3d pick = inFace(lower, T_target_pick.translation());
  const Eigen::Vector3d contact =
      lower.T_target_part * Eigen::Vector3d(pick.x(), pick.y(), lower.z);
  const Eigen::Vector3d x = inFace(upper, contact);
  return x.z() < -higherBy(upper) && isWithin(upper.contour, x.head<2>(), radius);
}

bool isCovered(const PickFace& face, const Eigen::Isometry3d& T_target_pick, double radius) {
  const Eigen::Vector2d pick = inFace(face, T_target_pick.translation()).head<2>();
  const double reach = radius + 0.5 * face.cell_size;
  return std::any_of(face.covered.begin(), face.covered.end(),
                     [&](const Eigen::Vector2d& cell) { return (cell - pick).norm() <= reach; });
}

}  // namespace planar_bin_picking
