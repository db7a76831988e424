// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/wall_bands.h"

#include "base/scatter.h"
#include "image/posed_point.h"
#include "image/profile.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Pixels off the outline from which on a band is seen, clear of the blurred edge; and beyond the
/// band to what is compared with it.
constexpr double kFirst = 0.75, kBeyond = 1.0;
/// Widths of walls, pixels: all narrower ones make the same band; of a wider one the lower edge is
/// seen by itself (wall_evidence.h); and from this one on a band is no clearer.
constexpr double kNarrowest = 1.5, kWidest = 5.0, kClear = 2.5;
/// Medians from which on a contrast says no more than that there is a band, and grey levels that a
/// picture without any contrast has of noise.
constexpr double kMedians = 2.0, kNoise = 1.0;
/// Standard deviation of the difference of widths, pixels, from which on the correlation tells all.
constexpr double kApart = 0.6;
constexpr std::size_t kFew = 20;  // points that tell nothing

/// By point of the outline.
struct Bands {
  std::vector<double> contrasts;  // of the band to what lies beyond, grey levels
  std::vector<double> apart;      // width of the wall in one pose less that in the other, pixels
};

double greyAt(const cv::Mat& image, const Eigen::Vector2d& p) {
  float out = 0.0f;
  addProfile(image, static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0f, 0.0f, 1, &out);
  return static_cast<double>(out);
}

Bands bandsOf(const cv::Mat& image, const std::vector<PosedPoints>& one,
              const std::vector<PosedPoints>& other, const Solid& solid, std::size_t count) {
  Bands out;
  for (std::size_t i = 0; i < count; ++i) {
    PosedPoint p, q;
    if (!pointAt(one, i, &p) || !pointAt(other, i, &q)) continue;
    const double width = wallWidth(solid, p.deep_px), other_width = wallWidth(solid, q.deep_px);
    const double widest = std::max({width, other_width, kNarrowest}), beyond = widest + kBeyond;
    const Eigen::Vector2d edge = 0.5 * (p.pixel + q.pixel), normal = (p.normal + q.normal) / 2.0;
    if (widest > kWidest || !fitsInside(image, edge, beyond)) continue;
    const double middle = kFirst + 0.5 * (widest - 1.0);
    out.contrasts.push_back(
        std::abs(greyAt(image, edge + middle * normal) - greyAt(image, edge + beyond * normal)));
    out.apart.push_back(std::min(width, kClear) - std::min(other_width, kClear));
  }
  return out;
}

Eigen::ArrayXd aboutMean(const std::vector<double>& values) {
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(),
                                             static_cast<Eigen::Index>(values.size()));
  return all - all.mean();
}

}  // namespace

double wallBands(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
                 const Solid& solid, const Eigen::Isometry3d& T_one,
                 const Eigen::Isometry3d& T_other) {
  Bands bands = bandsOf(edges.image, posePoints(camera, points, solid.radius, T_one),
                        posePoints(camera, points, solid.radius, T_other), solid, points.size());
  if (bands.contrasts.size() < kFew) return 0.0;
  // Of another part's edge the contrast would outweigh all others.
  const double most = kMedians * median(bands.contrasts) + kNoise;
  for (double& contrast : bands.contrasts) contrast = std::min(contrast, most);
  const Eigen::ArrayXd seen = aboutMean(bands.contrasts), apart = aboutMean(bands.apart);
  const double spread = std::sqrt(apart.square().mean());
  const double both = std::sqrt(seen.square().mean()) * spread;
  if (!(both > 0.0)) return 0.0;
  return (seen * apart).mean() / both * std::min(1.0, spread / kApart);
}

}  // namespace planar_bin_picking
