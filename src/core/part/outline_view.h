// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// An outline posed in front of the camera, in the form that the refinement wants: points relative
/// to the centre of the outline on the visible face, in units of the part's radius.
///
/// The pose is T_camera_centre; its increment is xi = [translation / radius; rotation] on the
/// right.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_model.h"

#include <vector>

namespace planar_bin_picking {

/// A point of the outline about its centre, lengths in radii of the part, z = 0.
struct LocalPoint {
  double x, y;    ///< position
  double tx, ty;  ///< unit tangent; the outward normal is (ty, -tx)
  int index;      ///< into PartModel::outline()
};

inline LocalPoint localPoint(const PartModel& part, int index) {
  const auto& p = part.outline()[index];
  const Eigen::Vector2d q = (p.position - part.center()) / part.radius();
  return {q.x(), q.y(), -p.normal.y(), p.normal.x(), index};
}

/// Every k-th sample (about `count`) of those `wanted` accepts.
template <class Wanted>
std::vector<LocalPoint> localPoints(const PartModel& part, int count, Wanted&& wanted) {
  std::vector<int> indices;
  const auto& outline = part.outline();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    if (wanted(outline[i])) indices.push_back(static_cast<int>(i));
  }
  const int n = static_cast<int>(indices.size());
  count = std::min(count, n);
  std::vector<LocalPoint> out;
  for (int i = 0; i < count; ++i) {
    out.push_back(localPoint(part, indices[static_cast<std::size_t>(i) * n / count]));
  }
  return out;
}

/// Moved into the material by `inset` radii: where the edges of a bevelled cut are seen.
inline void moveInward(double inset, std::vector<LocalPoint>* points) {
  for (auto& p : *points) {
    p.x -= inset * p.ty;
    p.y += inset * p.tx;
  }
}

/// T_part_centre of a face.
inline Eigen::Isometry3d centreOf(const PartModel& part, Face face) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << part.center(), part.faceZ(face);
  return T;
}

/// z of the far contour in the centre frame of a face, radii; 0 for a sheet of unknown thickness.
inline double farContourOf(const PartModel& part, Face face) {
  return (face == Face::kFront ? -1.0 : 1.0) * part.thickness() / part.radius();
}

/// T * exp(xi) with the translation of xi in radii; rotation first order is not enough, so exact.
inline Eigen::Isometry3d stepped(const Eigen::Isometry3d& T, const Vector6d& xi, double radius) {
  const Eigen::Vector3d w = xi.tail<3>();
  const double angle = w.norm();
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  if (angle > 0.0) step.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  step.translation() = radius * xi.head<3>();
  return T * step;
}

/// Normal equations of weighted scalar residuals in 6 unknowns: H xi = -b.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double cost = 0.0;

  /// The residual r changes by g_local . (displacement of the point (x, y, 0), in radii).
  void add(double x, double y, const Eigen::Vector3d& g_local, double r, double weight) {
    Vector6d J;
    // d(point) = v + w x p, hence g . d(point) = g . v + w . (p x g)
    J << g_local, y * g_local.z(), -x * g_local.z(), x * g_local.y() - y * g_local.x();
    H.noalias() += (weight * J) * J.transpose();
    b.noalias() += (weight * r) * J;
  }
};

}  // namespace planar_bin_picking
