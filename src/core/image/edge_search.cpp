// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/edge_search.h"

#include "base/simd.h"
#include "image/profile.h"

#include <cmath>
#include <cstring>

namespace planar_bin_picking {
namespace {

constexpr int kTaps = EdgeSearch::kTaps;
constexpr int kLanes = EdgeSearch::kLanes;
constexpr int kNoLevel = EdgeSearch::kNoLevel;
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

// Of the even filter: between sqrt(1/3) and 1 the energy odd^2 + even^2 has one peak, in the
// middle, both of a blurred step and of a blurred line.
constexpr double kEven = 0.95;
// Pixels that a profile stays off the image's border: a pair's distance, and interpolation.
constexpr double kMargin = 2.0;

/// Grey levels by place and lane.
constexpr int kPlacesMost = 2 * EdgeSearch::kMaxReach + 3;
using Places = std::array<float, kPlacesMost * kLanes>;
using Profiles = std::array<float, (kPlacesMost + 2 * kTaps) * kLanes>;
using FloatLanes = std::array<float, kLanes>;
using IntLanes = std::array<int, kLanes>;

/// Straight lines of unit steps through the image, one in each lane.
struct Lines {
  FloatLanes x, y, dx, dy;  ///< where they begin, and the step
};

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

/// Grey levels along the lines, bilinear. Fixed point: 16 fractional bits for the position, 8 for
/// the weights.
/// @pre all of it lies within the image
PBP_SIMD
static void sample(const std::uint8_t* data, int pitch, const Lines& lines, int n, float* levels) {
  constexpr float kOne = 65536.0f;  // of 16 fractional bits
  IntLanes x, y, dx, dy, at;
  std::array<std::uint32_t, kLanes> near;  // a place and its three neighbours, a byte each
  for (int l = 0; l < kLanes; ++l) {
    x[l] = static_cast<int>(lines.x[l] * kOne);
    y[l] = static_cast<int>(lines.y[l] * kOne);
    dx[l] = static_cast<int>(lines.dx[l] * kOne);
    dy[l] = static_cast<int>(lines.dy[l] * kOne);
  }
  for (int k = 0; k < n; ++k, levels += kLanes) {
    for (int l = 0; l < kLanes; ++l) at[l] = (y[l] >> 16) * pitch + (x[l] >> 16);
    for (int l = 0; l < kLanes; ++l) {
      const std::uint8_t *const p = data + at[l], *const q = p + pitch;
      const std::uint32_t above = p[0] | p[1] << 8, below = q[0] | q[1] << 8;
      near[l] = above | below << 16;
    }
    for (int l = 0; l < kLanes; ++l) {
      const int a = (x[l] >> 8) & 255, b = (y[l] >> 8) & 255;
      const int p0 = near[l] & 255, p1 = near[l] >> 8 & 255;
      const int q0 = near[l] >> 16 & 255, q1 = near[l] >> 24;
      const int above = (p0 << 8) + a * (p1 - p0), below = (q0 << 8) + a * (q1 - q0);
      levels[l] = static_cast<float>((above << 8) + b * (below - above)) * (1.0f / kOne);
      x[l] += dx[l];
      y[l] += dy[l];
    }
  }
}

/// The mean of two profiles to either side at all n places, and the slope from one to the other at
/// those from `first` to `last`.
PBP_SIMD
static void joinPair(const Profiles& left, int n, int first, int last, int pitch,
                     Profiles* right_to_mean, float* slope) {
  for (int i = first; i <= last; ++i, slope += pitch) {
    const float *const a = &left[i * kLanes], *const b = &(*right_to_mean)[i * kLanes];
    for (int l = 0; l < kLanes; ++l) slope[l] = (a[l] - b[l]) * (1.0f / (2.0f * kAside));
  }
  for (int i = 0; i < n * kLanes; ++i) (*right_to_mean)[i] = 0.5f * (left[i] + (*right_to_mean)[i]);
}

/// Answers at n places of p; reads kTaps places before and behind.
PBP_SIMD
static void filter(const float* p, const EdgeSearch::Filters& f, int n, int pitch, float* step,
                   float* line) {
  static_assert(kTaps == 3, "written out, so that the compiler takes several lanes at once");
  constexpr int k1 = kLanes, k2 = 2 * kLanes, k3 = 3 * kLanes;
  const float o1 = f.odd[0], o2 = f.odd[1], o3 = f.odd[2];
  const float e0 = f.even[0], e1 = f.even[1], e2 = f.even[2], e3 = f.even[3];
  for (int i = 0; i < n; ++i, p += kLanes, step += pitch, line += pitch) {
    FloatLanes odd, even;
    for (int l = 0; l < kLanes; ++l) {
      const float* const q = p + l;
      odd[l] = o1 * (q[k1] - q[-k1]) + o2 * (q[k2] - q[-k2]) + o3 * (q[k3] - q[-k3]);
      even[l] = e0 * q[0] + e1 * (q[k1] + q[-k1]) + e2 * (q[k2] + q[-k2]) + e3 * (q[k3] + q[-k3]);
    }
    std::copy(odd.begin(), odd.end(), step);
    std::copy(even.begin(), even.end(), line);
  }
}

PBP_SIMD
static void magnitude(const float* a, const float* b, int n, int pitch, float* out) {
  for (int i = 0; i < n; ++i, a += pitch, b += pitch, out += kLanes)
    for (int l = 0; l < kLanes; ++l) out[l] = std::sqrt(a[l] * a[l] + b[l] * b[l]);
}

namespace {

/// The strongest peak of each lane; a merit of 0 where there is none.
struct Peaks {
  FloatLanes merit, at_px, height;
  IntLanes place;  ///< of the responses
};

}  // namespace

/// @param least, clear  the height from which on a peak counts, and beyond which it counts no more
PBP_SIMD
static void findPeaks(const float* energy, int reach, const FloatLanes& least,
                      const FloatLanes& clear, Peaks* out) {
  const float share = 1.0f / static_cast<float>(reach + 1);
  for (int l = 0; l < kLanes; l += kFloatsOfVector) {
    FloatVector merit = {}, at_px = {}, height = {}, enough, most, before, here, after;
    IntVector place = {};
    load(&least[l], &enough);
    load(&clear[l], &most);
    load(energy + l, &before);
    load(energy + kLanes + l, &here);
    for (int i = 1; i < 2 * reach + 2; ++i, before = here, here = after) {
      load(energy + (i + 1) * kLanes + l, &after);
      // Of a parabola through the three; at a peak its curvature is negative.
      const FloatVector at = static_cast<float>(i - reach - 1) +
                             0.5f * (before - after) / (before - 2.0f * here + after);
      const FloatVector near = at * share;
      const FloatVector worth = (most < here ? most : here) * (1.0f - near * near);
      const IntVector is_better =
          (here >= enough) & (here >= before) & (here > after) & (worth > merit);
      merit = is_better ? worth : merit;
      at_px = is_better ? at : at_px;
      height = is_better ? here : height;
      place = is_better ? IntVector{} + i : place;
    }
    std::memcpy(&out->merit[l], &merit, sizeof merit);
    std::memcpy(&out->at_px[l], &at_px, sizeof at_px);
    std::memcpy(&out->height[l], &height, sizeof height);
    std::memcpy(&out->place[l], &place, sizeof place);
  }
}

/// Mean over each stretch at all n places.
/// @param responses  of the first of the points; `pitch` to the next place
PBP_SIMD
static void average(const float* responses, int pitch, int n,
                    const EdgeSearch::Stretches& stretches, int before, int behind, float* out) {
  std::array<FloatLanes, 2 * kLanes + 1> shares;  // by neighbour: 1 where it is of the stretch
  for (int d = -before; d <= behind; ++d)
    for (int l = 0; l < kLanes; ++l) {
      const int from = -stretches.before[l], to = stretches.behind[l];
      const bool is_of_it = (from <= d) & (d <= to);
      shares[d + before][l] = is_of_it ? 1.0f : 0.0f;
    }
  FloatLanes counts;
  for (int l = 0; l < kLanes; ++l)
    counts[l] = static_cast<float>(1 + stretches.before[l] + stretches.behind[l]);
  for (int i = 0; i < n; ++i, responses += pitch, out += kLanes) {
    FloatLanes sum{};
    for (int d = -before; d <= behind; ++d)
      for (int l = 0; l < kLanes; ++l) sum[l] += shares[d + before][l] * responses[l + d];
    for (int l = 0; l < kLanes; ++l) out[l] = sum[l] / counts[l];
  }
}

EdgeSearch::Responses::Responses(int places, int points)
    : places_(places),
      pitch_((points + kLanes - 1) / kLanes * kLanes + 2 * kLanes),
      values_(new float[static_cast<std::size_t>(3 * places + 2) * pitch_]),
      level_(static_cast<std::size_t>(pitch_), kNoLevel) {
  for (int i = 0; i < 3 * places + 2; ++i) {
    float* const row = values_.get() + i * pitch_;
    std::fill_n(row, kLanes, 0.0f);
    std::fill_n(row + pitch_ - kLanes, kLanes, 0.0f);
  }
}

EdgeSearch::EdgeSearch(const EdgeMap& edges, const SearchProfile& profile)
    : edges_(edges), profile_(profile), filters_(filtersOf(profile.sigma_px)) {}

void EdgeSearch::respond(const PosedPoints& points, int first, Responses* out) const {
  const int half = profile_.reach_px + kTaps + 1, n = 2 * half + 1, m = places();
  const auto& image = edges_.image;
  // One profile through the point, or one to either side, which tells the gradient's direction,
  // too.
  const float aside = profile_.paired ? kAside : 0.0f;
  Lines left, right;
  std::array<bool, kLanes> is_complete;
  for (int l = 0; l < kLanes; ++l) {
    is_complete[l] =
        points.is_in_front[l] && fitsInside(image, {points.x[l], points.y[l]}, half + kMargin);
    // What leaves the image looks at its first pixel.
    const float share = is_complete[l] ? 1.0f : 0.0f;
    const float nx = share * static_cast<float>(points.nx[l]);
    const float ny = share * static_cast<float>(points.ny[l]);
    const float x = is_complete[l] ? static_cast<float>(points.x[l]) : 0.0f;
    const float y = is_complete[l] ? static_cast<float>(points.y[l]) : 0.0f;
    left.dx[l] = right.dx[l] = nx;
    left.dy[l] = right.dy[l] = ny;
    left.x[l] = x - half * nx - aside * ny;
    left.y[l] = y - half * ny + aside * nx;
    right.x[l] = x - half * nx + aside * ny;
    right.y[l] = y - half * ny - aside * nx;
  }
  const int pitch = static_cast<int>(image.step);
  Profiles levels;
  sample(image.data, pitch, right, n, levels.data());
  if (profile_.paired) {
    Profiles other;
    sample(image.data, pitch, left, n, other.data());
    joinPair(other, n, kTaps - 1, kTaps + m, out->pitch(), &levels,
             out->at(Responses::kAcross, -1, first));
  }
  filter(levels.data() + kTaps * kLanes, filters_, m, out->pitch(),
         out->at(Responses::kStep, 0, first), out->at(Responses::kLine, 0, first));
  for (int l = 0; l < kLanes; ++l)
    out->level(first + l) = is_complete[l] ? static_cast<int>(levels[half * kLanes + l]) : kNoLevel;
}

namespace {

/// Mean over the stretch of point `first` + l of the slope at a place and its two neighbours.
float slopeAt(const EdgeSearch::Responses& responses, int place, int first, int l,
              const EdgeSearch::Stretches& stretches) {
  const auto slope = [&](int i) {
    return responses.at(EdgeSearch::Responses::kAcross, i, first + l);
  };
  const float *const before = slope(place - 1), *const here = slope(place),
                     *const after = slope(place + 1);
  float sum = 0.0f;
  for (int d = -stretches.before[l]; d <= stretches.behind[l]; ++d)
    sum += (before[d] + here[d] + after[d]) * (1.0f / 3.0f);
  return sum / static_cast<float>(1 + stretches.before[l] + stretches.behind[l]);
}

}  // namespace

EdgeSearch::Hits EdgeSearch::strongest(const Responses& responses, int first,
                                       const Stretches& stretches) const {
  // Local energy: where plates of one kind lie on one another, their contour is a dark or bright
  // line as often as a step, and the steps on either side of it are no contour.
  Places energy;
  const int before = *std::max_element(stretches.before.begin(), stretches.before.end());
  const int behind = *std::max_element(stretches.behind.begin(), stretches.behind.end());
  const float* const step = responses.at(Responses::kStep, 0, first);
  const float* const line = responses.at(Responses::kLine, 0, first);
  const int pitch = responses.pitch();
  if (before + behind == 0) {
    magnitude(step, line, places(), pitch, energy.data());
  } else {
    Places steps, lines;
    average(step, pitch, places(), stretches, before, behind, steps.data());
    average(line, pitch, places(), stretches, before, behind, lines.data());
    magnitude(steps.data(), lines.data(), places(), kLanes, energy.data());
  }
  FloatLanes least, clear;
  for (int l = 0; l < kLanes; ++l) {
    const float noise =
        stretches.noise_share[l] * edges_.noise[std::max(0, responses.level(first + l))];
    least[l] = kNoiseFactor * noise;
    clear[l] = kClear * noise;
  }
  Peaks peaks;
  findPeaks(energy.data(), profile_.reach_px, least, clear, &peaks);
  Hits hits;
  for (int l = 0; l < kLanes; ++l) {
    if (responses.level(first + l) == kNoLevel || peaks.merit[l] <= 0.0f) continue;
    const float t =
        profile_.paired ? slopeAt(responses, peaks.place[l], first, l, stretches) : 0.0f;
    const float g = kSlopeOfStep * peaks.height[l];
    hits[l] = {true, peaks.at_px[l], 0.0f, g / std::sqrt(g * g + t * t), peaks.height[l]};
  }
  return hits;
}

void findEach(const EdgeMap& edges, const SearchProfile& profile,
              const std::vector<PosedPoints>& points, std::vector<EdgeHit>* hits) {
  const EdgeSearch search(edges, profile);
  EdgeSearch::Responses responses = search.responsesOf(kLanes);
  const EdgeSearch::Stretches alone;
  hits->clear();
  for (const PosedPoints& block : points) {
    search.respond(block, 0, &responses);
    const auto found = search.strongest(responses, 0, alone);
    hits->insert(hits->end(), found.begin(), found.end());
  }
}

namespace {

/// Points of an outline in the image, kLanes to a block.
class OnContour {
 public:
  OnContour(const std::vector<PosedPoints>& points, const EdgeSearch::Responses& responses, int n)
      : points_(points), responses_(responses), n_(n) {}
  /// Whether the stretch about point i goes on from one point to the next.
  bool goesOn(int i, int from, int to) const {
    if (to < 0 || to >= n_ || responses_.level(to) == kNoLevel) return false;
    const PosedPoints &a = points_[i / kLanes], &b = points_[to / kLanes];
    const int k = i % kLanes, l = to % kLanes;
    return apart(to, i) <= kAlongPx && apart(to, from) <= kAlongPx &&
           a.nx[k] * b.nx[l] + a.ny[k] * b.ny[l] >= kAlongCosine;
  }
  double apart(int i, int j) const {
    const PosedPoints &a = points_[i / kLanes], &b = points_[j / kLanes];
    const double dx = a.x[i % kLanes] - b.x[j % kLanes], dy = a.y[i % kLanes] - b.y[j % kLanes];
    return std::sqrt(dx * dx + dy * dy);
  }

 private:
  const std::vector<PosedPoints>& points_;
  const EdgeSearch::Responses& responses_;
  int n_;
};

/// The stretches about the points from `first` on, of n.
EdgeSearch::Stretches stretchesOf(const OnContour& contour, const EdgeSearch::Responses& responses,
                                  int first, int n) {
  EdgeSearch::Stretches out;
  for (int l = 0; l < kLanes && first + l < n; ++l) {
    const int i = first + l;
    if (responses.level(i) == kNoLevel) continue;
    int from = i, to = i;
    while (i - from < kLanes && contour.goesOn(i, from, from - 1)) --from;
    while (to - i < kLanes && contour.goesOn(i, to, to + 1)) ++to;
    out.before[l] = i - from;
    out.behind[l] = to - i;
    if (from == to) continue;
    const double pairs =
        std::min(1.0 + contour.apart(from, to) / kPairPx, static_cast<double>(to - from + 1));
    out.noise_share[l] = static_cast<float>(1.0 / std::sqrt(pairs));
  }
  return out;
}

}  // namespace

void findHits(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
              const Solid& solid, const Eigen::Isometry3d& T_camera_centre,
              const SearchProfile& profile, std::vector<EdgeHit>* hits) {
  const EdgeSearch search(edges, profile);
  const int n = static_cast<int>(points.size());
  const std::vector<PosedPoints> at = posePoints(camera, points, solid.radius, T_camera_centre);
  EdgeSearch::Responses responses = search.responsesOf(n);
  for (int i = 0; i < n; i += kLanes) search.respond(at[i / kLanes], i, &responses);
  const OnContour contour(at, responses, n);
  hits->assign(points.size(), {});
  for (int i = 0; i < n; i += kLanes) {
    const auto found = search.strongest(responses, i, stretchesOf(contour, responses, i, n));
    for (int l = 0; l < kLanes && i + l < n; ++l) {
      EdgeHit& hit = (*hits)[i + l];
      hit = found[l];
      if (responses.level(i + l) != kNoLevel)
        hit.wall_px = static_cast<float>(wallWidth(solid, at[i / kLanes].gz[l]));
    }
  }
}

}  // namespace planar_bin_picking
