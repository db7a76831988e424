// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/field_alignment.h"

#include "image/posed_point.h"
#include "locate/refine/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kReachDecay = 0.85;  // per step: from a tenth of a part to two pixels in a dozen
constexpr double kTiltWeight = 20.0;  // per point: 10 degrees beyond the limit are one radius off
constexpr double kPriorWeight = 0.3;  // per point: 15 degrees off the voted tilt are 2 % of them
constexpr double kStepMost = 0.3;     // radii or radians: beyond, the points see other edges
constexpr int kBinsRenewed = 3;       // evaluations for which a point's direction bin is kept: time
constexpr double kSineLeast = 1e-6;   // of a tilt, against a division by zero

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
  if (q.z() <= kDepthLeast) return false;
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

/// Penalty for a tilt beyond the limit: Eq. (7) of [1], as a residual, since with its exponential
/// the normal equations would overflow.
void addTiltPenalty(const Eigen::Isometry3d& T, double limit, double weight, NormalEquations* eq) {
  const double c = std::min(1.0, std::abs(T.linear()(2, 2)));
  const double tilt = std::acos(c);
  if (tilt <= limit) return;
  // d tilt / d rotation about local x, y: the normal is local z, and z_camera in local axes is
  // row 2.
  const Eigen::Vector3d z = T.linear().row(2).transpose() * (T.linear()(2, 2) > 0 ? 1.0 : -1.0);
  const double s = std::max(kSineLeast, std::sqrt(z.x() * z.x() + z.y() * z.y()));
  Vector6d J = Vector6d::Zero();
  J(3) = z.y() / s;
  J(4) = -z.x() / s;
  eq->H.noalias() += weight * J * J.transpose();
  eq->b.noalias() += weight * (tilt - limit) * J;
  eq->cost += weight * (tilt - limit) * (tilt - limit);
}

/// The vote knows the tilt to within a cell of its own, and a small outline among other edges
/// hardly tells it: without this its shape collapses onto these. Rotated by (a, b) about its x and
/// y, the normal (0, 0, 1) becomes (b, -a, 1).
void addTiltPrior(const Eigen::Isometry3d& T, const Eigen::Vector3d& normal_voted, double weight,
                  NormalEquations* eq) {
  const Eigen::Vector3d n = T.linear().transpose() * normal_voted;
  eq->H(3, 3) += weight;
  eq->H(4, 4) += weight;
  eq->b(3) += weight * n.y();
  eq->b(4) -= weight * n.x();
  eq->cost += weight * (n.x() * n.x() + n.y() * n.y());
}

}  // namespace

Eigen::Isometry3d alignInField(const Field& field, const std::vector<LocalPoint>& points,
                               double radius, const Eigen::Isometry3d& T_camera_centre,
                               double reach_px, const RefineParams& params) {
  std::vector<int> bins(points.size(), 0);
  const auto evaluate = [&](const Eigen::Isometry3d& T, int k, double reach) {
    NormalEquations out;
    const double inv_reach2 = 1.0 / (reach * reach);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const LocalPoint& p = points[i];
      Seen s;
      if (!see(field, T, radius, p, &s)) {
        out.cost += 1.0;
        continue;
      }
      if (k % kBinsRenewed == 0) bins[i] = seenBin(T, p, s);
      const Sample d = sample(field, s, bins[i]);
      const double e = 1.0 - d.d * d.d * inv_reach2;
      if (e <= 0.0) {
        out.cost += 1.0;
        continue;
      }
      out.cost += 1.0 - e * e * e;  // Tukey's biweight
      const double scale = field.focal * radius * s.inv_z;
      const Eigen::Vector3d g(scale * d.gx, scale * d.gy, -scale * (d.gx * s.iu + d.gy * s.iv));
      out.add(pointJacobian(p, T.linear().transpose() * g), d.d, 3.0 * e * e * inv_reach2);
    }
    addTiltPrior(T, T_camera_centre.linear().col(2), kPriorWeight * points.size(), &out);
    addTiltPenalty(T, params.tilt_limit_deg * M_PI / 180.0, kTiltWeight * points.size(), &out);
    return out;
  };
  LevenbergMarquardtParams minimiser;
  minimiser.evaluations = params.field_iterations;
  minimiser.width = std::max(reach_px, params.field_reach_end_px);
  minimiser.width_end = params.field_reach_end_px;
  minimiser.width_decay = kReachDecay;
  return minimise(T_camera_centre, minimiser, evaluate,
                  [&](const Eigen::Isometry3d& T, const Vector6d& xi) {
                    return stepped(T, xi.cwiseMax(-kStepMost).cwiseMin(kStepMost), radius);
                  });
}

double fieldInlierScore(const Field& field, const std::vector<LocalPoint>& points, double radius,
                        const Eigen::Isometry3d& T_camera_centre, double reach_px) {
  double score = 0.0;
  for (const auto& p : points) {
    Seen s;
    if (!see(field, T_camera_centre, radius, p, &s)) continue;
    const double d = sample(field, s, seenBin(T_camera_centre, p, s)).d;
    score += std::max(0.0, 1.0 - d / reach_px);
  }
  return points.empty() ? 0.0 : score / static_cast<double>(points.size());
}

}  // namespace planar_bin_picking
