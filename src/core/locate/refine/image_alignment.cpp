// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/image_alignment.h"

#include "base/scatter.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace planar_bin_picking {
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
                      const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                      double tukey_px) {
  const EdgeSearch search(edges, profile);
  std::vector<Row> rows;
  rows.reserve(points.size());
  for (const auto& p : points) {
    PosedPoint at;
    if (!posePoint(camera, p, solid.radius, T_camera_centre, &at)) continue;
    const EdgeHit hit = search.at(at);
    if (!hit.found) continue;
    Row row;
    row.J = normalJacobian(p, at);
    row.offset = hit.offset_px;
    row.out_px = at.out_px;
    row.trust = trustOf(wallWidth(solid, at), profile.reach_px);
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
