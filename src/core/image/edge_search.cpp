// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/edge_search.h"

#include "base/simd.h"
#include "image/profile.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr int kTaps = EdgeSearch::kTaps;
constexpr int kMaxReach = 16;         // of SearchProfile::reach_px, for buffers without allocation
constexpr float kAside = 1.0f;        // pixels between a pair's profiles and the point
constexpr float kNoiseFactor = 4.0f;  // an edge on a profile is so many times the noise: as edgels
// Like Eq. (10), an edge counts no more than this many times the noise: beyond a clear edge, being
// near counts more than being strong.
constexpr float kClear = 12.0f;
// A blurred step of height 1 has a slope of about one half per pixel.
constexpr float kSlopeOfStep = 0.5f;

// Of the even filter: between sqrt(1/3) and 1 the energy odd^2 + even^2 has one peak, in the
// middle, both of a blurred step and of a blurred line.
constexpr double kEven = 0.95;
// Pixels that a profile stays off the image's border: a pair's distance, and interpolation.
constexpr double kMargin = 2.0;

using Profile = std::array<float, 2 * (kMaxReach + kTaps + 1) + 1>;

EdgeSearch::Filters filtersOf(double sigma) {
  EdgeSearch::Filters f;
  double sum = 0.0;
  for (int j = 1; j <= kTaps; ++j) sum += j * std::exp(-0.5 * j * j / (sigma * sigma));
  for (int j = 1; j <= kTaps; ++j) {
    const double q = j * j / (sigma * sigma), gauss = std::exp(-0.5 * q) / sum;
    f.odd[j - 1] = static_cast<float>(j * gauss);
    f.even[j] = static_cast<float>(kEven * sigma * (1.0 - q) * gauss);
    f.even[0] -= 2.0f * f.even[j];
  }
  return f;
}

}  // namespace

/// energy[i] = |(step, line)| at p[i], for i in 0..m-1; reads p[-kTaps] to p[m - 1 + kTaps].
PBP_SIMD
static void localEnergy(const float* p, const EdgeSearch::Filters& f, int m, float* energy) {
  static_assert(kTaps == 3, "written out, so that the compiler takes several i at once");
  const float o1 = f.odd[0], o2 = f.odd[1], o3 = f.odd[2];
  const float e0 = f.even[0], e1 = f.even[1], e2 = f.even[2], e3 = f.even[3];
  for (int i = 0; i < m; ++i) {
    const float* const q = p + i;
    const float step = o1 * (q[1] - q[-1]) + o2 * (q[2] - q[-2]) + o3 * (q[3] - q[-3]);
    const float line = e0 * q[0] + e1 * (q[1] + q[-1]) + e2 * (q[2] + q[-2]) + e3 * (q[3] + q[-3]);
    energy[i] = std::sqrt(step * step + line * line);
  }
}

EdgeSearch::EdgeSearch(const EdgeMap& edges, const SearchProfile& profile)
    : edges_(edges), profile_(profile), filters_(filtersOf(profile.sigma_px)) {}

EdgeHit EdgeSearch::at(const PosedPoint& point) const {
  const int reach = profile_.reach_px, half = reach + kTaps + 1, n = 2 * half + 1;
  EdgeHit hit;
  const auto& image = edges_.image;
  if (!fitsInside(image, point.pixel, half + kMargin)) return hit;
  // One profile through the point, or one to either side, which tells the gradient's direction,
  // too.
  Profile sum{}, other{};
  const float nx = static_cast<float>(point.normal.x()), ny = static_cast<float>(point.normal.y());
  const float x0 = static_cast<float>(point.pixel.x()) - half * nx;
  const float y0 = static_cast<float>(point.pixel.y()) - half * ny;
  if (profile_.paired) {
    addProfile(image, x0 - kAside * ny, y0 + kAside * nx, nx, ny, n, sum.data());
    addProfile(image, x0 + kAside * ny, y0 - kAside * nx, nx, ny, n, other.data());
  } else {
    addProfile(image, x0, y0, nx, ny, n, sum.data());
  }
  Profile across{};
  for (int k = 0; k < n && profile_.paired; ++k) {
    across[k] = (sum[k] - other[k]) / (2.0f * kAside);
    sum[k] = 0.5f * (sum[k] + other[k]);
  }
  // Local energy: where plates of one kind lie on one another, their contour is a dark or bright
  // line as often as a step, and the steps on either side of it are no contour.
  std::array<float, 2 * kMaxReach + 3> energy{};
  const int m = 2 * reach + 3;  // energy[i] stands at offset i - reach - 1
  localEnergy(sum.data() + kTaps, filters_, m, energy.data());
  const auto level = static_cast<int>(sum[half]);
  const float noise = edges_.noise[std::clamp(level, 0, 255)];
  float best = 0.0f;
  for (int i = 1; i + 1 < m; ++i) {
    const float a = energy[i], l = energy[i - 1], r = energy[i + 1];
    if (a < kNoiseFactor * noise || a < l || a <= r) continue;
    const float curve = l - 2 * a + r;
    const float at_px = i - reach - 1 + (curve < 0.0f ? 0.5f * (l - r) / curve : 0.0f);
    const float near = at_px / (reach + 1.0f);
    const float merit = std::min(a, kClear * noise) * (1.0f - near * near);
    if (merit <= best) continue;
    best = merit;
    hit.found = true;
    hit.offset_px = at_px;
    hit.cosine = 1.0f;
    if (profile_.paired) {
      const int c = i + kTaps;
      const float t = (across[c - 1] + across[c] + across[c + 1]) / 3.0f, g = kSlopeOfStep * a;
      hit.cosine = g / std::sqrt(g * g + t * t);
    }
  }
  return hit;
}

void findHits(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
              const Solid& solid, const Eigen::Isometry3d& T_camera_centre,
              const SearchProfile& profile, std::vector<EdgeHit>* hits) {
  const EdgeSearch search(edges, profile);
  hits->resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    PosedPoint at;
    (*hits)[i] = {};
    if (!posePoint(camera, points[i], solid.radius, T_camera_centre, &at)) continue;
    (*hits)[i] = search.at(at);
    (*hits)[i].wall_px = static_cast<float>(wallWidth(solid, at));
  }
}

}  // namespace planar_bin_picking
