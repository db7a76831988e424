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

/// Pixels off the outline from which on a band is seen; beyond the band to what is compared with
/// it; and inward to the face.
constexpr double kFirst = 0.75, kBeyond = 1.0, kInward = 2.5;
/// Widths of walls, pixels: all narrower ones make the same band; of a wider one the lower edge is
/// seen by itself (wall_evidence.h); and from this one on a band is no clearer.
constexpr double kNarrowest = 1.5, kWidest = 5.0, kClear = 2.5;
/// Medians from which on a contrast says no more than that there is a band, and grey levels that a
/// picture without any contrast has of noise.
constexpr double kMedians = 2.0, kNoise = 1.0;
/// Standard deviation of the difference of widths, pixels, from which on the correlation tells all.
constexpr double kApart = 0.6;
constexpr std::size_t kFew = 20;  // points that tell nothing

/// By point of the outline, in grey levels.
struct Bands {
  std::vector<double> steps;      // from the face to what lies beyond the band
  std::vector<double> contrasts;  // of the band to what lies beyond
  std::vector<double> losses;     // from the face to as far inward as the band lies outward
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
    if (widest > kWidest || !fitsInside(image, edge, std::max(beyond, kInward))) continue;
    const double middle = kFirst + 0.5 * (widest - 1.0);
    const double face = greyAt(image, edge - kInward * normal);
    const double floor = greyAt(image, edge + beyond * normal);
    out.steps.push_back(face - floor);
    out.contrasts.push_back(greyAt(image, edge + middle * normal) - floor);
    out.losses.push_back(face - greyAt(image, edge - middle * normal));
    out.apart.push_back(std::min(width, kClear) - std::min(other_width, kClear));
  }
  return out;
}

/// Share of the step that the blurred edge leaves where a pose has no wall, if that is the true
/// one; of the first pose with a `sign` of 1, of the other with -1. An edge is blurred as far
/// inward as outward, and a bevel loses more of the face inward.
double leftOf(const Bands& bands, double sign) {
  std::vector<double> sizes;
  for (const double step : bands.steps) sizes.push_back(std::abs(step));
  const double least = std::max(0.5 * median(sizes), kNoise);
  std::vector<double> outward, inward;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (sign * bands.apart[i] >= 0.0 || sizes[i] <= least) continue;
    outward.push_back(bands.contrasts[i] / bands.steps[i]);
    inward.push_back(bands.losses[i] / bands.steps[i]);
  }
  if (outward.empty()) return 0.0;
  return std::max(0.0, std::min(median(outward), median(inward)));
}

/// How far the contrasts are from what each of the poses would have without its walls, grey levels.
/// A dark wall under a blurred bright edge may be as bright as the floor, and then the side without
/// a wall has the contrast: with a share of each pose's own, neither is preferred.
std::vector<double> unexplained(const Bands& bands) {
  const double left = leftOf(bands, 1.0), left_other = leftOf(bands, -1.0);
  std::vector<double> out;
  for (std::size_t i = 0; i < bands.steps.size(); ++i) {
    const double contrast = bands.contrasts[i], step = bands.steps[i];
    out.push_back(std::abs(contrast - left * step) + std::abs(contrast - left_other * step));
  }
  // Of another part's edge the contrast would outweigh all others.
  const double most = kMedians * median(out) + kNoise;
  for (double& contrast : out) contrast = std::min(contrast, most);
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
  const Bands bands =
      bandsOf(edges.image, posePoints(camera, points, solid.radius, T_one),
              posePoints(camera, points, solid.radius, T_other), solid, points.size());
  if (bands.contrasts.size() < kFew) return 0.0;
  const Eigen::ArrayXd seen = aboutMean(unexplained(bands)), apart = aboutMean(bands.apart);
  const double spread = std::sqrt(apart.square().mean());
  const double both = std::sqrt(seen.square().mean()) * spread;
  if (!(both > 0.0)) return 0.0;
  return (seen * apart).mean() / both * std::min(1.0, spread / kApart);
}

}  // namespace planar_bin_picking
