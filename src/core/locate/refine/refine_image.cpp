// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/refine_image.h"

#include "base/scatter.h"
#include "base/simd.h"
#include "image/posed_point.h"
#include "image/profile.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace planar_bin_picking {
namespace {

constexpr int kTaps = 3;  // of the derivative filter on either side
constexpr int kMaxReach = 16;
constexpr float kAside = 1.0f;        // pixels between a pair's profiles and the point
constexpr double kNoiseFactor = 4.0;  // an edge on a profile is this far above the noise

/// Filters for a step and for a line, j = -kTaps..kTaps: derivatives of a Gaussian, odd and even.
struct Taps {
  std::array<float, kTaps> odd{};       // j = 1..kTaps; a unit step answers with 1
  std::array<float, kTaps + 1> even{};  // j = 0..kTaps; sums to zero
};

Taps tapsOf(double sigma) {
  // Of the even filter: between sqrt(1/3) and 1 the energy odd^2 + even^2 has one peak, in the
  // middle, both of a blurred step and of a blurred line.
  constexpr double kEven = 0.95;
  Taps f;
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
static void localEnergy(const float* p, const Taps& taps, int m, float* energy) {
  static_assert(kTaps == 3, "written out, so that the compiler takes several i at once");
  const float o1 = taps.odd[0], o2 = taps.odd[1], o3 = taps.odd[2];
  const float e0 = taps.even[0], e1 = taps.even[1], e2 = taps.even[2], e3 = taps.even[3];
  for (int i = 0; i < m; ++i) {
    const float* const q = p + i;
    const float step = o1 * (q[1] - q[-1]) + o2 * (q[2] - q[-2]) + o3 * (q[3] - q[-3]);
    const float line = e0 * q[0] + e1 * (q[1] + q[-1]) + e2 * (q[2] + q[-2]) + e3 * (q[3] + q[-3]);
    energy[i] = std::sqrt(step * step + line * line);
  }
}

namespace {

/// The strongest edge, nearer ones preferred.
EdgeHit bestEdge(const EdgeMap& edges, const PosedPoint& at, const ImageReach& reach,
                 const Taps& taps) {
  const int half = reach.reach_px + kTaps + 1, n = 2 * half + 1;
  EdgeHit hit;
  const auto& image = edges.image;
  if (!fitsInside(image, at.pixel, half + 2.0)) return hit;
  // One profile through the point, or one to either side, which tells the gradient's direction,
  // too.
  std::array<float, 2 * (kMaxReach + kTaps + 1) + 1> sum{}, other{};
  const float nx = static_cast<float>(at.normal.x()), ny = static_cast<float>(at.normal.y());
  const float x0 = static_cast<float>(at.pixel.x()) - half * nx;
  const float y0 = static_cast<float>(at.pixel.y()) - half * ny;
  if (reach.paired) {
    addProfile(image, x0 - kAside * ny, y0 + kAside * nx, nx, ny, n, sum.data());
    addProfile(image, x0 + kAside * ny, y0 - kAside * nx, nx, ny, n, other.data());
  } else {
    addProfile(image, x0, y0, nx, ny, n, sum.data());
  }
  std::array<float, 2 * (kMaxReach + kTaps + 1) + 1> across{};
  for (int k = 0; k < n && reach.paired; ++k) {
    across[k] = (sum[k] - other[k]) / (2.0f * kAside);
    sum[k] = 0.5f * (sum[k] + other[k]);
  }
  // Local energy: where plates of one kind lie on one another, their contour is a dark or bright
  // line as often as a step, and the steps on either side of it are no contour.
  std::array<float, 2 * kMaxReach + 3> energy{};
  const int m = 2 * reach.reach_px + 3;  // energy[i] stands at offset i - reach_px - 1
  localEnergy(sum.data() + kTaps, taps, m, energy.data());
  const auto level = static_cast<int>(sum[half]);
  const float noise = edges.noise[std::clamp(level, 0, 255)];
  float best = 0.0f;
  for (int i = 1; i + 1 < m; ++i) {
    const float a = energy[i], l = energy[i - 1], r = energy[i + 1];
    if (a < kNoiseFactor * noise || a < l || a <= r) continue;
    const float curve = l - 2 * a + r;
    const float at_px = i - reach.reach_px - 1 + (curve < 0.0f ? 0.5f * (l - r) / curve : 0.0f);
    const float near = at_px / (reach.reach_px + 1.0f);
    // Saturated like Eq. (10): beyond a clear edge, being near counts more than being strong.
    const float merit = std::min(a, 12.0f * noise) * (1.0f - near * near);
    if (merit <= best) continue;
    best = merit;
    hit.found = true;
    hit.offset_px = at_px;
    if (reach.paired) {
      const int c = i + kTaps;
      const float t = (across[c - 1] + across[c] + across[c + 1]) / 3.0f;
      const float g = 0.5f * a;  // a blurred step of height 1 has a slope of about one half
      hit.cosine = g / std::sqrt(g * g + t * t);
    } else {
      hit.cosine = 1.0f;
    }
  }
  return hit;
}

/// Width of the side wall outside the outline, pixels.
double wallOf(const Solid& solid, const PosedPoint& at) {
  return std::max(0.0, solid.far_contour * at.deep_px);
}

}  // namespace

void findHits(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
              const Solid& solid, const Eigen::Isometry3d& T_camera_centre, const ImageReach& reach,
              std::vector<EdgeHit>* hits) {
  const auto taps = tapsOf(reach.sigma_px);
  hits->resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    PosedPoint at;
    (*hits)[i] = {};
    if (!posePoint(camera, points[i], solid.radius, T_camera_centre, &at)) continue;
    (*hits)[i] = bestEdge(edges, at, reach, taps);
    (*hits)[i].wall_px = static_cast<float>(wallOf(solid, at));
  }
}

namespace {

/// One associated point: offset(xi) = offset + row . xi (+ inset * out_px).
struct Row {
  Vector6d J;
  double offset, out_px, trust;
};

/// Where the side wall is in view and narrow, its lower edge may be the stronger one, and nothing
/// tells which of the two was found: the rest of the outline should hold the pose.
double trustOf(double wall_px, double reach_px) {
  constexpr double kUnseen = 0.5, kAmbiguous = 0.3;
  return wall_px < kUnseen || wall_px > reach_px + 2.0 ? 1.0 : kAmbiguous;
}

struct WeightedSystem {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double cost = 0.0;
  int used = 0;
};

/// The pose moves by pixels within one association, so the projection counts as linear there.
WeightedSystem weigh(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px) {
  WeightedSystem s;
  const double inv2 = 1.0 / (tukey_px * tukey_px);
  for (const auto& row : rows) {
    const double r = row.J.dot(xi) - row.offset;
    const double e = 1.0 - r * r * inv2;
    if (e <= 0.0) {
      s.cost += row.trust;
      continue;
    }
    s.cost += row.trust * (1.0 - e * e * e);
    const Vector6d wJ = (row.trust * e * e) * row.J;
    s.H.noalias() += wJ * row.J.transpose();
    s.b.noalias() += r * wJ;
    ++s.used;
  }
  return s;
}

constexpr int kStretches = 24;
// What the residuals cannot tell: light, bevel and shadow move the edges of a whole side alike.
constexpr int kSides = 8;
constexpr double kBiasPx = 0.3;
constexpr double kInsetBiasPx = 0.1;  // most of it is what makes the inset, and no error of it
// What is known without any edge, that the pose is within a radius and a radian, as so many edges
// with an error of a pixel.
constexpr double kPrior = 1.0;

/// Covariance of the settled pose, and pose and inset together by the final weights.
void judge(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px, ImagePose* out) {
  const double inv2 = 1.0 / (tukey_px * tukey_px);
  WeightedSystem s = weigh(rows, xi, tukey_px);
  Vector6d h = Vector6d::Zero();
  double hh = 0.0, c = 0.0;
  // Few stretches may agree by chance: no edge is better than the bias.
  Matrix6d meat = kBiasPx * kBiasPx * s.H + kPrior * Matrix6d::Identity();
  Vector6d stretch = Vector6d::Zero(), shift = Vector6d::Zero();
  const int n = static_cast<int>(rows.size());
  int stretches = 0;
  for (int i = 0; i < n; ++i) {
    const Row& row = rows[i];
    const double r = row.J.dot(xi) - row.offset, e = 1.0 - r * r * inv2;
    if (e > 0.0) {
      const double w = row.trust * e * e;
      stretch += (w * r) * row.J;
      shift += w * row.J;
      // The predicted edge moves inward: its offset along the outward normal falls by inset *
      // out_px.
      h -= (w * row.out_px) * row.J;
      hh += w * row.out_px * row.out_px;
      c -= w * row.out_px * r;
    }
    if ((i + 1) * kStretches / n != i * kStretches / n) {
      meat += stretch * stretch.transpose();
      stretches += stretch.isZero(0.0) ? 0 : 1;
      stretch.setZero();
    }
    if ((i + 1) * kSides / n != i * kSides / n) {
      meat += (kBiasPx * kBiasPx) * shift * shift.transpose();
      shift.setZero();
    }
  }
  s.H.diagonal().array() += kPrior;
  const auto solver = s.H.ldlt();
  const Matrix6d inverse = solver.solve(Matrix6d::Identity());
  // Six unknowns follow the stretches; of six or fewer nothing is left to tell the error by.
  const double left = std::max(1, stretches - 6);
  out->covariance = inverse * meat * inverse * (std::max(7, stretches) / left);
  out->per_inset = -solver.solve(h);
  const Vector6d g = solver.solve(h);
  const double information = hh - h.dot(g);
  if (information <= 0.0) return;
  out->inset = -(c - g.dot(s.b)) / information;
  double variance = std::max(0.01, out->residual_px * out->residual_px) / information;
  double side = 0.0;  // what a pixel of bias on a side does to the inset
  for (int i = 0; i < n; ++i) {
    const Row& row = rows[i];
    const double r = row.J.dot(xi) - row.offset, e = 1.0 - r * r * inv2;
    if (e > 0.0) side += row.trust * e * e * (row.out_px + g.dot(row.J)) / information;
    if ((i + 1) * kSides / n == i * kSides / n) continue;
    variance += kInsetBiasPx * kInsetBiasPx * side * side;
    side = 0.0;
  }
  out->inset_sigma = std::sqrt(variance);
}

double robustSpread(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px) {
  std::vector<double> absolute;
  for (const auto& row : rows) {
    const double r = std::abs(row.J.dot(xi) - row.offset);
    if (r < tukey_px) absolute.push_back(r);
  }
  return absolute.empty() ? tukey_px : 1.4826 * median(std::move(absolute));
}

}  // namespace

ImagePose stepInImage(const EdgeMap& edges, const Camera& camera,
                      const std::vector<LocalPoint>& points, const Solid& solid,
                      const Eigen::Isometry3d& T_camera_centre, const ImageReach& reach,
                      double tukey_px) {
  const auto taps = tapsOf(reach.sigma_px);
  std::vector<Row> rows;
  rows.reserve(points.size());
  for (const auto& p : points) {
    PosedPoint at;
    if (!posePoint(camera, p, solid.radius, T_camera_centre, &at)) continue;
    const EdgeHit hit = bestEdge(edges, at, reach, taps);
    if (!hit.found) continue;
    Row row;
    row.J = normalJacobian(p, at);
    row.offset = hit.offset_px;
    row.out_px = at.out_px;
    row.trust = trustOf(wallOf(solid, at), reach.reach_px);
    rows.push_back(row);
  }
  ImagePose out;
  out.T_camera_centre = T_camera_centre;
  Vector6d xi = Vector6d::Zero();
  WeightedSystem system = weigh(rows, xi, tukey_px);
  // Levenberg-Marquardt: the rotation about a slender part's axis is so weakly held that undamped
  // steps leap.
  double lambda = 1e-3;
  for (int k = 0; k < 5 && system.used >= kFewEdges; ++k) {
    Matrix6d H = system.H;
    H.diagonal() += lambda * system.H.diagonal();
    H.diagonal().array() += 1e-7 * system.H.trace() + 1e-12;
    const Vector6d step = -H.ldlt().solve(system.b);
    const Vector6d next_xi = (xi + step).cwiseMax(-0.15).cwiseMin(0.15);
    const WeightedSystem next = weigh(rows, next_xi, tukey_px);
    if (next.cost > system.cost) {
      lambda *= 10.0;
      continue;
    }
    const bool settled = next.cost > system.cost - 1e-4 * rows.size();
    xi = next_xi;
    system = next;
    lambda *= 0.3;
    if (settled) break;
  }
  out.used = system.used;
  if (out.used < kFewEdges) return out;
  out.T_camera_centre = stepped(T_camera_centre, xi, solid.radius);
  out.residual_px = robustSpread(rows, xi, tukey_px);
  judge(rows, xi, tukey_px, &out);
  return out;
}

}  // namespace planar_bin_picking
