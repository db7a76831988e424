// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "views/view_starts.h"

#include "base/parallel.h"
#include "base/plane_pose.h"
#include "locate/evidence/inlier_score.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr SearchProfile kWide{12, false, 1.2}, kNarrow{4, true, 0.8};
constexpr std::array<double, 3> kWideTukey{12.0, 8.0, 4.0};
/// Steps of the search move the part by so many pixels in the new view: well within the reach.
constexpr double kStepPx = 10.0;
constexpr int kStepsMost = 12;  // to either side
constexpr double kInlierReachPx = 2.0;
/// Normals closer than this (3 degrees) are one start; places closer than this one, too.
constexpr double kTiltsApart = 0.05, kPlacesApartPx = 4.0;
constexpr std::size_t kStartsMost = 4;
/// Inlier scores farther behind the best are not made up for by the first view.
constexpr double kHopeless = 0.25;

/// The other plane that looks nearly the same in the first view ([4]), where it is another one.
std::vector<Eigen::Isometry3d> tilts(const Eigen::Isometry3d& T) {
  std::vector<Eigen::Isometry3d> out{T};
  const Eigen::Vector2d p = T.translation().hnormalized();
  Eigen::Matrix<double, 2, 3> project;
  project << 1, 0, -p.x(), 0, 1, -p.y();
  const Eigen::Matrix2d A = project * T.linear().leftCols<2>() / T.translation().z();
  for (const Eigen::Isometry3d& plane : posesFromAffine(A, p)) {
    Eigen::Isometry3d other = plane;
    other.translation() = T.translation();
    if ((other.linear().col(2) - T.linear().col(2)).norm() > kTiltsApart) out.push_back(other);
  }
  return out;
}

bool looksBack(const SeenPart& seen, const Eigen::Isometry3d& T_view_centre) {
  const double sign = seen.face == Face::kFront ? 1.0 : -1.0;
  return T_view_centre.translation().z() > 0.0 &&
         sign * T_view_centre.linear().col(2).dot(T_view_centre.translation()) < 0.0;
}

bool isSame(const ImagePose& a, const ImagePose& b, const View& view) {
  const Eigen::Vector2d apart = view.camera().project(a.T_camera_centre.translation()) -
                                view.camera().project(b.T_camera_centre.translation());
  return apart.norm() < kPlacesApartPx &&
         (a.T_camera_centre.linear().col(2) - b.T_camera_centre.linear().col(2)).norm() <
             kTiltsApart;
}

}  // namespace

double scoreIn(const SeenPart& seen, const View& view, const Eigen::Isometry3d& T_view_centre,
               const std::vector<LocalPoint>& points) {
  if (!looksBack(seen, T_view_centre)) return 0.0;
  std::vector<EdgeHit> hits;
  findHits(edgesOf(view), view.camera(), points, seen.solid, T_view_centre, kNarrow, &hits);
  return inlierScore(hits, kInlierReachPx);
}

std::vector<Eigen::Isometry3d> startsAbout(const SeenPart& seen,
                                           const Eigen::Isometry3d& T_first_centre,
                                           const View& view, double reach) {
  const Eigen::Vector3d ray = T_first_centre.translation().normalized();
  const Eigen::Isometry3d T_view_first = view.T_first_this().inverse();
  const auto pixelAt = [&](double depth) {
    return view.camera().project(T_view_first * (T_first_centre.translation() + depth * ray));
  };
  std::vector<Eigen::Isometry3d> out;
  if ((T_view_first * T_first_centre.translation()).z() <= 2.0 * reach) return out;
  const double px_per_metre = (pixelAt(0.5 * reach) - pixelAt(-0.5 * reach)).norm() / reach;
  const int steps =
      std::min(kStepsMost, static_cast<int>(std::ceil(px_per_metre * reach / kStepPx)));
  for (const Eigen::Isometry3d& tilt : tilts(T_first_centre)) {
    for (int i = 0; i <= 2 * steps; ++i) {
      const int k = (i % 2 == 0 ? 1 : -1) * (i + 1) / 2;  // 0, -1, 1, -2, 2 ...
      Eigen::Isometry3d T = tilt;
      if (steps > 0) T.translation() += reach * k / steps * ray;
      if (looksBack(seen, T) && looksBack(seen, T_view_first * T)) out.push_back(T);
    }
  }
  return out;
}

std::vector<ViewStart> bestStarts(const SeenPart& seen, const View& view, double offset,
                                  const std::vector<Eigen::Isometry3d>& starts, int threads) {
  const EdgeMap edges = edgesOf(view);
  const Eigen::Isometry3d T_view_first = view.T_first_this().inverse();
  const auto coarse = inward(seen.coarse, offset / seen.solid.radius);
  const auto fine = inward(seen.fine, offset / seen.solid.radius);
  std::vector<ViewStart> all(starts.size());
  parallelFor(static_cast<int>(starts.size()), threads, [&](int i) {
    ViewStart& start = all[static_cast<std::size_t>(i)];
    start.T_first_centre = starts[static_cast<std::size_t>(i)];
    start.own.T_camera_centre = T_view_first * start.T_first_centre;
    for (const double tukey : kWideTukey) {
      start.own = alignInImage(edges, view.camera(), coarse, seen.solid, start.own.T_camera_centre,
                               kWide, tukey);
    }
    start.score = scoreIn(seen, view, start.own.T_camera_centre, coarse);
  });
  std::stable_sort(all.begin(), all.end(),
                   [](const ViewStart& a, const ViewStart& b) { return a.score > b.score; });
  std::vector<ViewStart> out;
  for (const ViewStart& start : all) {
    if (out.size() == kStartsMost || start.score < all.front().score - kHopeless) break;
    if (start.own.status != AlignmentStatus::kAligned) continue;
    const bool known = std::any_of(out.begin(), out.end(), [&](const ViewStart& other) {
      return isSame(start.own, other.own, view);
    });
    if (!known) out.push_back(start);
  }
  parallelFor(static_cast<int>(out.size()), threads, [&](int i) {
    ViewStart& start = out[static_cast<std::size_t>(i)];
    for (const double tukey : {3.0, 2.0}) {
      start.own = alignInImage(edges, view.camera(), fine, seen.solid, start.own.T_camera_centre,
                               kNarrow, tukey);
    }
    start.score = scoreIn(seen, view, start.own.T_camera_centre, fine);
  });
  return out;
}

}  // namespace planar_bin_picking
