// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/print_evidence.h"

#include "image/posed_point.h"
#include "image/profile.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

// Pixels. Of the widest stroke, half the width; beside a stroke, how far its ground begins and ends
// from its border (blur lies between); of a border, how far its two sides reach.
constexpr int kWidest = 5, kGroundFrom = 2, kGroundTo = 3, kSide = 3;
constexpr int kHalf = kWidest + kGroundTo + 1;  // pixels along the normal to either side
constexpr float kNoise = 4.0f;  // a stroke stands out this many times the noise, as an edgel does
constexpr float kAside = 1.0f;  // pixels between the two profiles and the point
constexpr double kMargin =
    2.0;  // pixels that a profile stays off the image's border: interpolation

using Profile = std::array<float, 2 * kHalf + 1>;

/// Mean of profile pixels from..to about the middle.
float meanOf(const Profile& p, int from, int to) {
  float sum = 0.0f;
  for (int i = from; i <= to; ++i) sum += p[kHalf + i];
  return sum / static_cast<float>(to - from + 1);
}

/// Response to a stroke about the middle that is darker (negative) or lighter than both sides: the
/// smaller of the two steps, of the width that answers most.
float strokeOf(const Profile& p) {
  float best = 0.0f;
  for (int half = 0; half <= kWidest; ++half) {
    const float inside = meanOf(p, -half, half);
    const float left = inside - meanOf(p, -half - kGroundTo, -half - kGroundFrom);
    const float right = inside - meanOf(p, half + kGroundFrom, half + kGroundTo);
    if ((left > 0.0f) != (right > 0.0f)) continue;
    const float step = std::abs(left) < std::abs(right) ? left : right;
    if (std::abs(step) > std::abs(best)) best = step;
  }
  return best;
}

/// Response to a border in the middle.
float borderOf(const Profile& p) { return meanOf(p, 1, kSide) - meanOf(p, -kSide, -1); }

/// Counts the responses that stand out, by polarity.
struct Shares {
  int dark = 0, light = 0;
  void add(float response, float floor) {
    dark += response < -floor;
    light += response > floor;
  }
  int most() const { return std::max(dark, light); }
};

}  // namespace

double printScore(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
                  double radius, const Eigen::Isometry3d& T_camera_centre) {
  Shares strokes, borders;
  const auto seen = posePoints(camera, points, radius, T_camera_centre);
  for (std::size_t i = 0; i < points.size(); ++i) {
    PosedPoint at;
    if (!pointAt(seen, i, &at)) continue;
    if (!fitsInside(edges.image, at.pixel, kHalf + kMargin)) continue;
    Profile sum{};
    for (const float side : {-kAside, kAside}) {
      const auto nx = static_cast<float>(at.normal.x()), ny = static_cast<float>(at.normal.y());
      addProfile(edges.image, static_cast<float>(at.pixel.x()) - kHalf * nx - side * ny,
                 static_cast<float>(at.pixel.y()) - kHalf * ny + side * nx, nx, ny, 2 * kHalf + 1,
                 sum.data());
    }
    for (float& v : sum) v *= 0.5f;
    const float floor = kNoise * edges.noise[std::clamp(static_cast<int>(sum[kHalf]), 0, 255)];
    strokes.add(strokeOf(sum), floor);
    borders.add(borderOf(sum), floor);
  }
  return points.empty()
             ? 0.0
             : std::max(strokes.most(), borders.most()) / static_cast<double>(points.size());
}

}  // namespace planar_bin_picking
