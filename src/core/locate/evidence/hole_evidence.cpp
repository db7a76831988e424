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
constexpr double kSeen = 0.85;      // inlier score from which on the hole is where it is drawn
constexpr double kReachPx = 1.5;    // off the contour from which on an edge is no inlier: as score
// Pixels along a normal while the other place is sought: a share of the hole's width, since beyond
// lies its opposite rim, within these limits.
constexpr double kFarShare = 0.25;
constexpr int kFarLeast = 4, kFarMost = 12;
// Starts around the drawn place, besides that itself, a narrower and a wider one; how far off they
// lie: a share of the width, and pixels at most. With the reach above they cover half a width.
constexpr int kAround = 8;
constexpr double kStartShare = 0.2, kStartMost = 16.0;
// Pixels: nearer, it may be the same rim: its bevel or its shadow.
constexpr double kApartPx = 2.5;
constexpr double kApartShare = 0.5;  // of the width: farther off, it is another hole
constexpr std::size_t kFew = 8;      // points that have an edge: fewer do not determine a circle
// Of the fit: rounds, and Tukey's width per round and at last, pixels, with which eight rounds are
// enough for the widest reach. The damping is that of a thousandth of one point.
constexpr int kRounds = 8;
constexpr double kDecay = 0.75, kEnd = 1.5;
constexpr double kDamping = 1e-3;

/// The hole moved and made narrower, in radii of the part.
struct Change {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double narrower = 0.0;  // of its own radius
};

std::vector<LocalPoint> changed(std::vector<LocalPoint> points, const Change& by) {
  moveInward(-by.narrower, &points);
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
  change->narrower += x.z() / px_per_radius;
  return true;
}

std::vector<Change> startsAround(double off) {
  std::vector<Change> out(1);
  for (const double narrower : {-off, off}) out.push_back({Eigen::Vector2d::Zero(), narrower});
  for (int k = 0; k < kAround; ++k) {
    const double azimuth = 2.0 * M_PI * k / kAround;
    out.push_back({off * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth)), 0.0});
  }
  return out;
}

/// How far beside its upper rim the hole's lower one is seen, in radii along the face.
Eigen::Vector2d lowerRim(const Solid& solid, const Eigen::Isometry3d& T_camera_centre,
                         const std::vector<LocalPoint>& points) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& p : points)
    middle += Eigen::Vector2d(p.x, p.y) / static_cast<double>(points.size());
  const Eigen::Vector3d camera = T_camera_centre.inverse().translation() / solid.radius;
  const double share = solid.far_contour / (camera.z() - solid.far_contour);
  return share * (middle - camera.head<2>());
}

/// Whether the change is none that edges of a right pose explain. The hole's own wall: its lower
/// rim is the upper one shifted, and with a part of each the hole seems narrower by half of that.
/// And what lies below or above the hole: a contour within the drawn one that has another middle.
bool isAnotherHole(const Change& change, const Eigen::Vector2d& lower_rim, double apart) {
  const double wall = lower_rim.norm();
  const Eigen::Vector2d along = wall > 0.0 ? Eigen::Vector2d(lower_rim / wall) : lower_rim;
  const double moved =
      (change.shift - std::clamp(change.shift.dot(along), 0.0, wall) * along).norm();
  const double resized = change.narrower - std::clamp(change.narrower, 0.0, 0.5 * wall);
  if (moved > apart) return change.shift.norm() > change.narrower;
  return std::abs(resized) > apart;
}

/// By how much the other contour is likelier than the drawn one; point by point, as these
/// correspond.
double leadOf(const std::vector<EdgeHit>& other, const std::vector<EdgeHit>& drawn) {
  double sum = 0.0;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const double higher = std::max(other[i].height, drawn[i].height);
    if (higher <= 0.0) continue;
    sum += (other[i].height * inlierScore(other[i], kReachPx) -
            drawn[i].height * inlierScore(drawn[i], kReachPx)) /
           higher;
  }
  return drawn.empty() ? 0.0 : sum / static_cast<double>(drawn.size());
}

}  // namespace

HoleEvidence holeEvidence(const EdgeMap& edges, const Camera& camera,
                          const std::vector<LocalPoint>& points, const Solid& solid,
                          const Eigen::Isometry3d& T_camera_centre, double width_px) {
  HoleEvidence out;
  std::vector<EdgeHit> drawn, hits;
  findHits(edges, camera, points, solid, T_camera_centre, kInlierProfile, &drawn);
  out.here = inlierScore(drawn, kReachPx);
  if (width_px < kResolved || out.here > kSeen) return out;
  const Eigen::Vector2d lower_rim = lowerRim(solid, T_camera_centre, points);
  const double px_per_radius = camera.model().fx * solid.radius / T_camera_centre.translation().z();
  const double off = std::min(kStartShare * width_px, kStartMost) / px_per_radius;
  const int reach = std::clamp(static_cast<int>(kFarShare * width_px), kFarLeast, kFarMost);
  for (Change change : startsAround(off)) {
    for (const int within : {reach, kInlierProfile.reach_px}) {
      const auto moved = changed(points, change);
      findHits(edges, camera, moved, solid, T_camera_centre,
               {within, true, kInlierProfile.sigma_px}, &hits);
      if (!fit(moved, hits, within, px_per_radius, &change)) break;
    }
    const double apart = std::max(change.shift.norm(), std::abs(change.narrower)) * px_per_radius;
    if (apart > kApartShare * width_px ||
        !isAnotherHole(change, lower_rim, kApartPx / px_per_radius)) {
      continue;
    }
    findHits(edges, camera, changed(points, change), solid, T_camera_centre, kInlierProfile, &hits);
    out.lead = std::max(out.lead, leadOf(hits, drawn));
  }
  return out;
}

}  // namespace planar_bin_picking
