// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// An outline posed in front of the camera, in the form that the refinement wants: points relative
/// to the centre of the outline on the visible face, in units of the part's radius.
///
/// The pose is T_camera_centre; its increment xi is that of se3.h with the translation in radii.

#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_model.h"

#include <algorithm>
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

/// Every k-th of the samples, about `count`.
inline std::vector<int> thinned(const std::vector<int>& indices, int count) {
  const std::size_t n = indices.size();
  count = std::min(count, static_cast<int>(n));
  std::vector<int> out;
  for (int i = 0; i < count; ++i)
    out.push_back(indices[static_cast<std::size_t>(i) * n / static_cast<std::size_t>(count)]);
  return out;
}

/// Those of the samples that `wanted` accepts.
template <class Wanted>
std::vector<int> indicesOf(const PartModel& part, Wanted&& wanted) {
  std::vector<int> indices;
  const auto& outline = part.outline();
  for (std::size_t i = 0; i < outline.size(); ++i)
    if (wanted(outline[i])) indices.push_back(static_cast<int>(i));
  return indices;
}

/// About `count` samples of outer contour and holes: by length, but at least half of them on the
/// outer contour. Many holes in a row look alike from one pitch to the next, and say little of
/// where the part lies.
inline std::vector<int> shapeIndices(const PartModel& part, int count) {
  const auto outer =
      indicesOf(part, [](const OutlinePoint& p) { return p.kind == LoopKind::kOuter; });
  const auto holes =
      indicesOf(part, [](const OutlinePoint& p) { return p.kind == LoopKind::kHole; });
  if (outer.size() >= holes.size())
    return thinned(
        indicesOf(part, [](const OutlinePoint& p) { return p.kind != LoopKind::kPrint; }), count);
  auto out = thinned(outer, count / 2);
  const auto rest = thinned(holes, count - count / 2);
  out.insert(out.end(), rest.begin(), rest.end());
  return out;
}

inline std::vector<LocalPoint> localPointsAt(const PartModel& part,
                                             const std::vector<int>& indices) {
  std::vector<LocalPoint> out;
  for (const int index : indices) out.push_back(localPoint(part, index));
  return out;
}

/// Every k-th sample (about `count`) of those `wanted` accepts.
template <class Wanted>
std::vector<LocalPoint> localPoints(const PartModel& part, int count, Wanted&& wanted) {
  return localPointsAt(part, thinned(indicesOf(part, wanted), count));
}

/// Moved into the material by `offset` radii: where the edges of a bevelled cut are seen.
inline void moveInward(double offset, std::vector<LocalPoint>* points) {
  for (auto& p : *points) {
    p.x -= offset * p.ty;
    p.y += offset * p.tx;
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

/// T * exp(xi) (se3.h) with the translation of xi in radii.
inline Eigen::Isometry3d stepped(const Eigen::Isometry3d& T, const Vector6d& xi, double radius) {
  Vector6d metric = xi;
  metric.head<3>() *= radius;
  return T * exp(metric);
}

/// Derivative by xi, in units of the radius, of a quantity that changes by g_local . (displacement
/// of the point (x, y, 0), in radii): d(point) = v + w x p, hence g . v + w . (p x g).
inline Vector6d pointJacobian(const LocalPoint& p, const Eigen::Vector3d& g_local) {
  Vector6d J;
  J << g_local, p.y * g_local.z(), -p.x * g_local.z(), p.x * g_local.y() - p.y * g_local.x();
  return J;
}

}  // namespace planar_bin_picking
