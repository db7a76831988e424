// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/field_alignment.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kReachDecay = 0.85;  // per iteration
constexpr double kTiltWeight =
    20.0;  // of the penalty, per point: 10 degrees count like one radius off

/// A point's place in the field: its direction bin is renewed only now and then.
struct Seen {
  double u, v;    // field pixels
  double iu, iv;  // ideal image plane
  double inv_z;
};

bool see(const Field& field, const Eigen::Isometry3d& T, double radius, const LocalPoint& p,
         Seen* out) {
  const Eigen::Vector3d q =
      T.translation() + radius * (p.x * T.linear().col(0) + p.y * T.linear().col(1));
  if (q.z() <= 1e-6) return false;
  out->inv_z = 1.0 / q.z();
  out->iu = q.x() * out->inv_z;
  out->iv = q.y() * out->inv_z;
  out->u = field.focal * out->iu + field.cx;
  out->v = field.focal * out->iv + field.cy;
  return out->u >= 0.0 && out->v >= 0.0 && out->u < field.width - 1 && out->v < field.height - 1;
}

int seenBin(const Eigen::Isometry3d& T, const LocalPoint& p, const Seen& s) {
  const Eigen::Vector3d d = p.tx * T.linear().col(0) + p.ty * T.linear().col(1);
  return directionBin(d.y() - s.iv * d.z(), -(d.x() - s.iu * d.z()));
}

struct Sample {
  double d, gx, gy;  // field pixels and per field pixel
};

Sample sample(const Field& field, const Seen& s, int bin) {
  const int x = static_cast<int>(s.u), y = static_cast<int>(s.v);
  const double a = s.u - x, b = s.v - y;
  const std::uint8_t* p = field.at(x, y) + bin;
  const std::uint8_t* q = p + static_cast<std::size_t>(field.width) * kDirections;
  const double p0 = p[0], p1 = p[kDirections], q0 = q[0], q1 = q[kDirections];
  constexpr double k = 1.0 / kUnitsPerFieldPixel;
  return {k * ((1 - b) * ((1 - a) * p0 + a * p1) + b * ((1 - a) * q0 + a * q1)),
          k * ((1 - b) * (p1 - p0) + b * (q1 - q0)), k * ((1 - a) * (q0 - p0) + a * (q1 - p1))};
}

/// Beyond the limit the tilt is pulled back (Eq. 7, as a residual: its exponential would make the
/// normal equations blow up).
void addTiltPenalty(const Eigen::Isometry3d& T, double limit, double weight, NormalEquations* eq) {
  const double c = std::min(1.0, std::abs(T.linear()(2, 2)));
  const double tilt = std::acos(c);
  if (tilt <= limit) return;
  // d tilt / d rotation about local x, y: the normal is local z, and z_camera in local axes is
  // row 2.
  const Eigen::Vector3d z = T.linear().row(2).transpose() * (T.linear()(2, 2) > 0 ? 1.0 : -1.0);
  const double s = std::max(1e-6, std::sqrt(z.x() * z.x() + z.y() * z.y()));
  Vector6d J = Vector6d::Zero();
  J(3) = z.y() / s;
  J(4) = -z.x() / s;
  eq->H.noalias() += weight * J * J.transpose();
  eq->b.noalias() += weight * (tilt - limit) * J;
  eq->cost += weight * (tilt - limit) * (tilt - limit);
}

}  // namespace

FieldPose settleInField(const Field& field, const std::vector<LocalPoint>& points, double radius,
                        const Eigen::Isometry3d& T_camera_centre, double reach_px,
                        const RefineParams& params) {
  Eigen::Isometry3d T = T_camera_centre, T_best = T;
  std::vector<int> bins(points.size(), 0);
  const double limit = params.tilt_limit_deg * M_PI / 180.0;
  double lambda = 1e-3;
  double last_cost = -1.0;
  NormalEquations accepted;
  double reach = reach_px;
  for (int k = 0; k < params.field_iterations; ++k) {
    NormalEquations eq;
    const double inv_reach2 = 1.0 / (reach * reach);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const LocalPoint& p = points[i];
      Seen s;
      if (!see(field, T, radius, p, &s)) {
        eq.cost += 1.0;
        continue;
      }
      if (k % 3 == 0) bins[i] = seenBin(T, p, s);
      const Sample d = sample(field, s, bins[i]);
      const double e = 1.0 - d.d * d.d * inv_reach2;
      if (e <= 0.0) {
        eq.cost += 1.0;
        continue;
      }
      eq.cost += 1.0 - e * e * e;  // Tukey's biweight
      const double scale = field.focal * radius * s.inv_z;
      const Eigen::Vector3d g(scale * d.gx, scale * d.gy, -scale * (d.gx * s.iu + d.gy * s.iv));
      eq.add(p.x, p.y, T.linear().transpose() * g, d.d, 3.0 * e * e * inv_reach2);
    }
    addTiltPenalty(T, limit, kTiltWeight * points.size(), &eq);
    const bool better = last_cost < 0.0 || eq.cost <= last_cost;
    if (better) {
      T_best = T;
      accepted = eq;
      lambda = std::max(1e-4, lambda * 0.3);
    } else {
      lambda = std::min(1e3, lambda * 8.0);
    }
    Matrix6d H = accepted.H;
    const double damp = lambda * H.trace() / 6.0 + 1e-9;
    H.diagonal() += (lambda * accepted.H.diagonal().array() + 0.02 * damp + 1e-9).matrix();
    const Vector6d xi = -H.ldlt().solve(accepted.b);
    T = stepped(T_best, xi.cwiseMax(-0.3).cwiseMin(0.3), radius);
    const double next = std::max(params.field_reach_end_px, reach * kReachDecay);
    // Costs compare only at the same reach, so a new reach starts a new comparison.
    last_cost = next < reach ? -1.0 : (better ? eq.cost : last_cost);
    reach = next;
  }
  FieldPose out;
  out.T_camera_centre = T_best;
  out.support = supportInField(field, points, radius, T_best, 1.5 * params.field_reach_end_px);
  return out;
}

double supportInField(const Field& field, const std::vector<LocalPoint>& points, double radius,
                      const Eigen::Isometry3d& T_camera_centre, double reach_px) {
  double support = 0.0;
  for (const auto& p : points) {
    Seen s;
    if (!see(field, T_camera_centre, radius, p, &s)) continue;
    const double d = sample(field, s, seenBin(T_camera_centre, p, s)).d;
    support += std::max(0.0, 1.0 - d / reach_px);
  }
  return points.empty() ? 0.0 : support / static_cast<double>(points.size());
}

}  // namespace planar_bin_picking
