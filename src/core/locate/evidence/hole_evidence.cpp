// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/hole_evidence.h"

#include "image/posed_point.h"
#include "locate/evidence/inlier_score.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kResolved = 10.0;  // pixels: of a narrower hole both rims lie within one profile
constexpr double kUnseen = 0.4;     // inlier score from which on the hole is where it is drawn
constexpr double kReachPx = 1.5;    // off the contour from which on an edge is no inlier: as score
constexpr SearchProfile kNear{3, true, 0.8};  // as for the score: twice that, and a sharp edge
// Pixels along a normal while the other place is sought: a share of the hole's width, since beyond
// lies its opposite rim, within these limits.
constexpr double kFarShare = 0.25;
constexpr int kFarLeast = 4, kFarMost = 12;
// Starts around the drawn place, besides that itself; how far off they lie: a share of the width,
// and pixels at most. With the reach above they cover half a width to all sides.
constexpr int kStarts = 8;
constexpr double kStartShare = 0.2, kStartMost = 16.0;
// Pixels: nearer, it may be the same rim: its bevel, its shadow, or the wall below it.
constexpr double kApartPx = 2.5;
constexpr double kApartShare = 0.5;  // of the width: farther off, it is another hole
constexpr std::size_t kFew = 8;      // points that have an edge: fewer do not determine a circle
// Of the fit: rounds, and Tukey's width per round and at last, pixels, with which eight rounds are
// enough for the widest reach. The damping is that of a thousandth of one point.
constexpr int kRounds = 8;
constexpr double kDecay = 0.75, kEnd = 1.5;
constexpr double kDamping = 1e-3;

/// The hole moved and grown, in radii of the part.
struct Change {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double grown = 0.0;
};

std::vector<LocalPoint> changed(std::vector<LocalPoint> points, const Change& by) {
  moveInward(-by.grown, &points);
  for (auto& p : points) {
    p.x += by.shift.x();
    p.y += by.shift.y();
  }
  return points;
}

/// The change that brings the contour onto the edges within reach; robust.
bool fit(const std::vector<LocalPoint>& points, const std::vector<EdgeHit>& hits, double reach_px,
         double px_per_radius, Change* change) {
  std::size_t found = 0;
  for (const auto& hit : hits) found += hit.found;
  if (found < kFew) return false;
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  double tukey = reach_px;
  for (int round = 0; round < kRounds; ++round, tukey = std::max(kEnd, kDecay * tukey)) {
    Eigen::Matrix3d H = kDamping * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!hits[i].found) continue;
      const Eigen::Vector3d row(points[i].ty, -points[i].tx, 1.0);
      const double r = hits[i].offset_px - row.dot(x), e = 1.0 - r * r / (tukey * tukey);
      if (e <= 0.0) continue;
      H += e * e * row * row.transpose();
      b += e * e * r * row;
    }
    x += H.ldlt().solve(b);
  }
  // Along the outward normal: into the hole, which shrinks it.
  change->shift += x.head<2>() / px_per_radius;
  change->grown += x.z() / px_per_radius;
  return true;
}

}  // namespace

HoleEvidence holeEvidence(const EdgeMap& edges, const Camera& camera,
                          const std::vector<LocalPoint>& points, const Solid& solid,
                          const Eigen::Isometry3d& T_camera_centre, double width_px) {
  HoleEvidence out;
  std::vector<EdgeHit> hits;
  findHits(edges, camera, points, solid, T_camera_centre, kNear, &hits);
  out.here = inlierScore(hits, kReachPx);
  if (width_px < kResolved || out.here > kUnseen) return out;
  double wall_px = 0.0;
  for (const auto& hit : hits) wall_px = std::max(wall_px, static_cast<double>(hit.wall_px));
  const double px_per_radius = camera.model().fx * solid.radius / T_camera_centre.translation().z();
  const double start = std::min(kStartShare * width_px, kStartMost) / px_per_radius;
  const int reach = std::clamp(static_cast<int>(kFarShare * width_px), kFarLeast, kFarMost);
  for (int k = 0; k <= kStarts; ++k) {
    Change change;
    const double azimuth = 2.0 * M_PI * k / kStarts;
    if (k < kStarts) change.shift = start * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
    for (const int within : {reach, kNear.reach_px}) {
      const auto moved = changed(points, change);
      findHits(edges, camera, moved, solid, T_camera_centre, {within, true, kNear.sigma_px}, &hits);
      if (!fit(moved, hits, within, px_per_radius, &change)) break;
    }
    const double apart = std::max(change.shift.norm(), std::abs(change.grown)) * px_per_radius;
    if (apart < kApartPx + wall_px || apart > kApartShare * width_px) continue;
    findHits(edges, camera, changed(points, change), solid, T_camera_centre, kNear, &hits);
    out.elsewhere = std::max(out.elsewhere, inlierScore(hits, kReachPx));
  }
  return out;
}

}  // namespace planar_bin_picking
