// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/edge_search.h"

#include "base/simd.h"
#include "image/profile.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr int kTaps = EdgeSearch::kTaps;
constexpr int kMaxReach = EdgeSearch::kMaxReach;
constexpr float kAside = 1.0f;        // pixels between a pair's profiles and the point
constexpr float kNoiseFactor = 4.0f;  // an edge on a profile is so many times the noise: as edgels
// Like Eq. (10), an edge counts no more than this many times the noise: beyond a clear edge, being
// near counts more than being strong.
constexpr float kClear = 12.0f;
// A blurred step of height 1 has a slope of about one half per pixel.
constexpr float kSlopeOfStep = 0.5f;
// Neighbours along the contour: within so many pixels, where the contour turns by no more than
// 25 degrees. Longer stretches would average over nicks and teeth.
constexpr double kAlongPx = 5.0, kAlongCosine = 0.9;
// A pair's profiles stand for so many pixels of the contour; noise that spans as many is one.
constexpr double kPairPx = 3.0;
constexpr int kNoLevel = -1;  // of a point whose profile leaves the image

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

/// Answers at p[i], for i in 0..m-1; reads p[-kTaps] to p[m - 1 + kTaps].
PBP_SIMD
static void filter(const float* p, const EdgeSearch::Filters& f, int m, float* step, float* line) {
  static_assert(kTaps == 3, "written out, so that the compiler takes several i at once");
  const float o1 = f.odd[0], o2 = f.odd[1], o3 = f.odd[2];
  const float e0 = f.even[0], e1 = f.even[1], e2 = f.even[2], e3 = f.even[3];
  for (int i = 0; i < m; ++i) {
    const float* const q = p + i;
    step[i] = o1 * (q[1] - q[-1]) + o2 * (q[2] - q[-2]) + o3 * (q[3] - q[-3]);
    line[i] = e0 * q[0] + e1 * (q[1] + q[-1]) + e2 * (q[2] + q[-2]) + e3 * (q[3] + q[-3]);
  }
}

PBP_SIMD
static void magnitude(const float* a, const float* b, int m, float* out) {
  for (int i = 0; i < m; ++i) out[i] = std::sqrt(a[i] * a[i] + b[i] * b[i]);
}

EdgeSearch::EdgeSearch(const EdgeMap& edges, const SearchProfile& profile)
    : edges_(edges), profile_(profile), filters_(filtersOf(profile.sigma_px)) {}

EdgeSearch::Response EdgeSearch::respond(const PosedPoint& point) const {
  const int half = profile_.reach_px + kTaps + 1, n = 2 * half + 1, m = places();
  Response out;
  const auto& image = edges_.image;
  out.complete = fitsInside(image, point.pixel, half + kMargin);
  if (!out.complete) return out;
  // One profile through the point, or one to either side, which tells the gradient's direction,
  // too.
  Profile sum{}, other{};
  const float nx = static_cast<float>(point.normal.x()), ny = static_cast<float>(point.normal.y());
  const float x0 = static_cast<float>(point.pixel.x()) - half * nx;
  const float y0 = static_cast<float>(point.pixel.y()) - half * ny;
  if (profile_.paired) {
    addProfile(image, x0 - kAside * ny, y0 + kAside * nx, nx, ny, n, sum.data());
    addProfile(image, x0 + kAside * ny, y0 - kAside * nx, nx, ny, n, other.data());
    Profile across{};
    for (int k = 0; k < n; ++k) {
      across[k] = (sum[k] - other[k]) / (2.0f * kAside);
      sum[k] = 0.5f * (sum[k] + other[k]);
    }
    for (int i = 0; i < m; ++i)
      out.across[i] = (across[i + kTaps - 1] + across[i + kTaps] + across[i + kTaps + 1]) / 3.0f;
  } else {
    addProfile(image, x0, y0, nx, ny, n, sum.data());
    std::fill_n(out.across.begin(), m, 0.0f);
  }
  filter(sum.data() + kTaps, filters_, m, out.step.data(), out.line.data());
  out.level = std::clamp(static_cast<int>(sum[half]), 0, 255);
  return out;
}

EdgeHit EdgeSearch::strongest(const Response& response, float noise_share) const {
  EdgeHit hit;
  if (!response.complete) return hit;
  const int reach = profile_.reach_px, m = places();
  // Local energy: where plates of one kind lie on one another, their contour is a dark or bright
  // line as often as a step, and the steps on either side of it are no contour.
  Response::Places energy;
  magnitude(response.step.data(), response.line.data(), m, energy.data());
  const float noise = noise_share * edges_.noise[response.level];
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
    hit.height = a;
    const float t = response.across[i], g = kSlopeOfStep * a;
    hit.cosine = g / std::sqrt(g * g + t * t);
  }
  return hit;
}

namespace {

/// Of all points before each, so that the mean over any stretch is one difference.
class RunningSums {
 public:
  RunningSums(std::size_t points, int places) : places_(places), sums_(points + 1) {
    for (auto* values : {&sums_[0].step, &sums_[0].line, &sums_[0].across}) values->fill(0.0f);
  }
  void set(int i, const EdgeSearch::Response& r) {
    const auto& from = sums_[i];
    auto& to = sums_[i + 1];
    if (!r.complete) {
      to = from;
      return;
    }
    for (int k = 0; k < places_; ++k) {
      to.step[k] = from.step[k] + r.step[k];
      to.line[k] = from.line[k] + r.line[k];
      to.across[k] = from.across[k] + r.across[k];
    }
  }
  /// Of points `first` to `last`, both among them.
  EdgeSearch::Response mean(int first, int last) const {
    const auto &before = sums_[first], &after = sums_[last + 1];
    const float share = 1.0f / static_cast<float>(last - first + 1);
    EdgeSearch::Response out;
    for (int k = 0; k < places_; ++k) {
      out.step[k] = share * (after.step[k] - before.step[k]);
      out.line[k] = share * (after.line[k] - before.line[k]);
      out.across[k] = share * (after.across[k] - before.across[k]);
    }
    return out;
  }

 private:
  int places_;
  std::vector<EdgeSearch::Response> sums_;
};

}  // namespace

void findHits(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
              const Solid& solid, const Eigen::Isometry3d& T_camera_centre,
              const SearchProfile& profile, std::vector<EdgeHit>* hits) {
  const EdgeSearch search(edges, profile);
  const int n = static_cast<int>(points.size());
  std::vector<PosedPoint> at(points.size());
  std::vector<int> level(points.size(), kNoLevel);
  RunningSums sums(points.size(), search.places());
  for (int i = 0; i < n; ++i) {
    EdgeSearch::Response response;
    if (posePoint(camera, points[i], solid.radius, T_camera_centre, &at[i]))
      response = search.respond(at[i]);
    if (response.complete) level[i] = response.level;
    sums.set(i, response);
  }
  hits->assign(points.size(), {});
  for (int i = 0; i < n; ++i) {
    if (level[i] == kNoLevel) continue;
    const auto goesOn = [&](int from, int to) {
      return to >= 0 && to < n && level[to] != kNoLevel &&
             (at[to].pixel - at[i].pixel).norm() <= kAlongPx &&
             (at[to].pixel - at[from].pixel).norm() <= kAlongPx &&
             at[to].normal.dot(at[i].normal) >= kAlongCosine;
    };
    int first = i, last = i;
    while (goesOn(first, first - 1)) --first;
    while (goesOn(last, last + 1)) ++last;
    EdgeSearch::Response mean = sums.mean(first, last);
    mean.complete = true;
    mean.level = level[i];
    const double pairs =
        std::min(1.0 + (at[last].pixel - at[first].pixel).norm() / kPairPx, last - first + 1.0);
    (*hits)[i] = search.strongest(mean, static_cast<float>(1.0 / std::sqrt(pairs)));
    (*hits)[i].wall_px = static_cast<float>(wallWidth(solid, at[i]));
  }
}

}  // namespace planar_bin_picking
