// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/align/field_alignment.h"

#include "base/simd.h"
#include "locate/align/column_sums.h"

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

/// Of a block: the weighted rows of Jacobians, columns of the normal equations by lane.
struct Rows {
  static constexpr int kUnknowns = 6;
  using Lanes = FieldBlock::Lanes<double>;
  std::array<Lanes, kUnknowns> J, weighted;
  Lanes is_used, cost;
};

/// What a step of the pose does, in plain numbers: the scale and the pose's rotation by columns.
struct Motion {
  double scale, xx, xy, xz, yx, yy, yz, zx, zy, zz;
};

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

/// Tukey's biweight, and how the distances follow the pose.
PBP_SIMD
static void weigh(const FieldBlock& block, const double* x, const double* y, const Motion& motion,
                  double inv_reach2, Rows* out) {
  const Motion m = motion;  // of its own, so that no store below can change it
  for (int k = 0; k < block.count; ++k) {
    const double d = block.d[k], e = 1.0 - d * d * inv_reach2;
    const double near = 0.5 * (e + std::abs(e)) * block.is_inside[k];  // 0 beyond the reach
    const double weight = 3.0 * near * near * inv_reach2;
    out->is_used[k] = weight > 0.0 ? 1.0 : 0.0;
    out->cost[k] = block.is_real[k] * (1.0 - near * near * near);
    const double scale = m.scale * block.inv_z[k];
    const double gx = scale * block.gx[k], gy = scale * block.gy[k];
    const double gz = -(gx * block.iu[k] + gy * block.iv[k]);
    const double lx = m.xx * gx + m.xy * gy + m.xz * gz, ly = m.yx * gx + m.yy * gy + m.yz * gz;
    const double lz = m.zx * gx + m.zy * gy + m.zz * gz;
    const double about_x = y[k] * lz, about_y = -x[k] * lz, about_z = x[k] * ly - y[k] * lx;
    out->J[0][k] = lx;  // as pointJacobian has it
    out->J[1][k] = ly;
    out->J[2][k] = lz;
    out->J[3][k] = about_x;
    out->J[4][k] = about_y;
    out->J[5][k] = about_z;
    out->weighted[0][k] = weight * lx;
    out->weighted[1][k] = weight * ly;
    out->weighted[2][k] = weight * lz;
    out->weighted[3][k] = weight * about_x;
    out->weighted[4][k] = weight * about_y;
    out->weighted[5][k] = weight * about_z;
  }
}

/// Adds the block's part of H, b, cost and the number of used points.
PBP_SIMD
static void sumUp(const FieldBlock& block, const Rows& rows, NormalEquations* out) {
  const int n = block.count;
  Columns weighted, J;
  for (int i = 0; i < Rows::kUnknowns; ++i) {
    weighted[i] = rows.weighted[i].data();
    J[i] = rows.J[i].data();
  }
  addColumns(weighted, J, block.d.data(), n, out);
  out->cost += dot(rows.cost.data(), block.is_real.data(), n);
  out->used += static_cast<int>(dot(rows.is_used.data(), block.is_real.data(), n));
}

/// Sum over the block: 1 on an edgel, 0 from the reach on.
PBP_SIMD
static double nearness(const FieldBlock& block, double inv_reach) {
  FieldBlock::Lanes<double> near;
  for (int k = 0; k < block.count; ++k) {
    const double share = 1.0 - block.d[k] * inv_reach;
    near[k] = share > 0.0 ? share : 0.0;
  }
  return dot(near.data(), block.is_inside.data(), block.count);
}

Eigen::Isometry3d alignInField(const Field& field, const FieldPoints& points, double radius,
                               const Eigen::Isometry3d& T_camera_centre, double reach_px,
                               const RefineParams& params) {
  std::vector<FieldBlock> blocks(static_cast<std::size_t>(blocksOf(points)));
  Rows rows;
  const auto evaluate = [&](const Eigen::Isometry3d& T, int k, double reach) {
    NormalEquations out;
    const Eigen::Matrix3d R = T.linear();
    const Motion motion{field.focal * radius,
                        R(0, 0),
                        R(1, 0),
                        R(2, 0),
                        R(0, 1),
                        R(1, 1),
                        R(2, 1),
                        R(0, 2),
                        R(1, 2),
                        R(2, 2)};
    for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
      look(field, points, radius, T, i, k % kBinsRenewed == 0, &blocks[i]);
      const int first = i * FieldBlock::kMost;
      weigh(blocks[i], &points.x[first], &points.y[first], motion, 1.0 / (reach * reach), &rows);
      sumUp(blocks[i], rows, &out);
    }
    out.H.triangularView<Eigen::StrictlyUpper>() = out.H.transpose();
    addTiltPrior(T, T_camera_centre.linear().col(2), kPriorWeight * points.count, &out);
    addTiltPenalty(T, params.tilt_limit_deg * M_PI / 180.0, kTiltWeight * points.count, &out);
    return out;
  };
  LevenbergMarquardtParams minimiser;
  minimiser.evaluations = params.field_iterations;
  minimiser.width = std::max(reach_px, params.field_reach_end_px);
  minimiser.width_end = params.field_reach_end_px;
  minimiser.width_decay = kReachDecay;
  const auto advance = [&](const Eigen::Isometry3d& T, const Vector6d& xi) {
    return stepped(T, xi.cwiseMax(-kStepMost).cwiseMin(kStepMost), radius);
  };
  return minimise(T_camera_centre, minimiser, evaluate, advance).state;
}

double fieldInlierScore(const Field& field, const FieldPoints& points, double radius,
                        const Eigen::Isometry3d& T_camera_centre, double reach_px) {
  FieldBlock block;
  double score = 0.0;
  for (int i = 0; i < blocksOf(points); ++i) {
    look(field, points, radius, T_camera_centre, i, true, &block);
    score += nearness(block, 1.0 / reach_px);
  }
  return points.count == 0 ? 0.0 : score / points.count;
}

}  // namespace planar_bin_picking
