// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/align/image_alignment.h"

#include "base/scatter.h"
#include "base/simd.h"
#include "locate/align/column_sums.h"
#include "locate/align/levenberg_marquardt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace planar_bin_picking {
namespace {

/// Where a side wall is in view and narrow, its lower edge may be the stronger one, and nothing
/// tells which of the two was found: the rest of the outline should determine the pose. Narrower
/// than half a pixel both are one edge; two pixels beyond the reach the lower one is not found.
constexpr double kWallUnseenPx = 0.5, kWallBeyondReachPx = 2.0, kTrustNarrowWall = 0.3;

/// A step within one association moves no point farther than this many radii or radians: beyond,
/// the projection is no longer linear and the edges found are others.
constexpr double kStepMost = 0.15;
constexpr int kEvaluations = 6;      // of the cost; the edges found are associated anew after them
constexpr double kGainLeast = 1e-4;  // of the cost per point: a smaller gain ends the steps

/// Neighbouring points err alike; this many clusters along the outline err independently: enough to
/// estimate six unknowns, and each is long beside a shadow or a nick.
constexpr int kClusters = 24;
constexpr int kUnknowns = 6;  // of a pose
/// What residuals cannot tell: light moves all edges that face the same way alike, shadow and an
/// uneven bevel a whole piece of the outline, together by about this much, and as nothing tells
/// which of the two, each has half of the variance. And light from one side moves opposite edges
/// the same way, which shifts the pose (with both the errors of the scenes fit their covariances,
/// test/benchmark). Most of the first is what makes the edge offset, and no error of it.
constexpr int kSides = 8;  // ways to face, and pieces of the outline
constexpr double kBiasPx = 0.22, kLightPx = 0.1, kOffsetBiasPx = 0.1;
/// Of a pose that one view tells: what lies on the part has edges, too, and some of them pass for
/// the part's own, the more the more of its outline is not found. So the variance is this much of
/// the above where all of it is found, and grows by this much for each point that is not, per point
/// that is.
constexpr double kAllFound = 0.7, kNotFound = 1.5;
/// What is known without any edge, that the pose is within a radius and a radian, as so many edges
/// with an error of a pixel.
constexpr double kPrior = 1.0;
/// Edges agree to a tenth of a pixel at best.
constexpr double kLeastVariancePx2 = 0.01;
constexpr double kSigmaOfMedian = 1.4826;  // of a Gaussian

using Row = AlignmentRow;

/// Tukey's biweight at the end of the steps.
struct Weighted {
  double residual, weight;  // weight 0: an outlier
};

Weighted weighted(const Row& row, const Vector6d& xi, double tukey_px) {
  const double r = row.J.dot(xi) - row.offset, e = 1.0 - r * r / (tukey_px * tukey_px);
  return {r, e > 0.0 ? row.trust * e * e : 0.0};
}

double robustSpread(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px) {
  std::vector<double> absolute;
  for (const auto& row : rows) {
    const double r = std::abs(row.J.dot(xi) - row.offset);
    if (r < tukey_px) absolute.push_back(r);
  }
  return absolute.empty() ? tukey_px : kSigmaOfMedian * median(std::move(absolute));
}

/// Whether point i of n is the last of one of `pieces` equal pieces of the outline.
bool endsPiece(int i, int n, int pieces) { return (i + 1) * pieces / n != i * pieces / n; }

/// Which of the directions the row's edge faces, in the part: the drawing's axes are the middles of
/// four of them.
std::size_t sideOf(const Row& row) {
  const double eighths = (std::atan2(row.J(1), row.J(0)) / M_PI + 1.0) * (kSides / 2);
  return static_cast<std::size_t>(eighths + 0.5) % kSides;
}

/// Covariance of the aligned pose by the sandwich estimator: H^-1 (sum of the clusters' score
/// vectors, squared) H^-1.
Matrix6d covarianceOf(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px,
                      const Matrix6d& H, const Matrix6d& H_inverse) {
  // Few clusters may agree by chance: no edge is better than the bias.
  Matrix6d squares = kBiasPx * kBiasPx * H + kPrior * Matrix6d::Identity();
  Vector6d score = Vector6d::Zero(), piece = Vector6d::Zero();
  std::array<Vector6d, kSides> sides;
  sides.fill(Vector6d::Zero());
  const int n = static_cast<int>(rows.size());
  int clusters = 0;
  for (int i = 0; i < n; ++i) {
    const auto [r, w] = weighted(rows[i], xi, tukey_px);
    score += (w * r) * rows[i].J;
    sides[sideOf(rows[i])] += w * rows[i].J;
    piece += w * rows[i].J;
    if (endsPiece(i, n, kClusters)) {
      squares += score * score.transpose();
      clusters += score.isZero(0.0) ? 0 : 1;
      score.setZero();
    }
    if (endsPiece(i, n, kSides)) {
      squares += (0.5 * kBiasPx * kBiasPx) * piece * piece.transpose();
      piece.setZero();
    }
  }
  for (const Vector6d& side : sides) squares += (0.5 * kBiasPx * kBiasPx) * side * side.transpose();
  // Six unknowns follow the clusters; of six or fewer nothing is left to tell the error by.
  const double left = std::max(1, clusters - kUnknowns);
  return H_inverse * squares * H_inverse * (std::max(kUnknowns + 1, clusters) / left);
}

/// Pose and edge offset together, by the final weights.
void tellOffset(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px,
                const Eigen::LDLT<Matrix6d>& solver, const Vector6d& b, ImagePose* out) {
  Vector6d h = Vector6d::Zero();
  double hh = 0.0, c = 0.0;
  for (const Row& row : rows) {
    const auto [r, w] = weighted(row, xi, tukey_px);
    // The predicted edge moves inward: its offset along the outward normal falls by the edge
    // offset times out_px.
    h -= (w * row.out_px) * row.J;
    hh += w * row.out_px * row.out_px;
    c -= w * row.out_px * r;
  }
  const Vector6d g = solver.solve(h);
  out->per_offset = -g;
  const double information = hh - h.dot(g);
  if (information <= 0.0) return;
  out->offset = -(c - g.dot(b)) / information;
  double variance = std::max(kLeastVariancePx2, out->residual_px * out->residual_px) / information;
  double side = 0.0;  // what a pixel of bias on a side does to the offset
  const int n = static_cast<int>(rows.size());
  for (int i = 0; i < n; ++i) {
    const double w = weighted(rows[i], xi, tukey_px).weight;
    side += w * (rows[i].out_px + g.dot(rows[i].J)) / information;
    if (!endsPiece(i, n, kSides)) continue;
    variance += kOffsetBiasPx * kOffsetBiasPx * side * side;
    side = 0.0;
  }
  out->offset_sigma = std::sqrt(variance);
}

}  // namespace

Eigen::Matrix3d lightVariance(const std::vector<Row>& rows,
                              const Eigen::Isometry3d& T_camera_centre) {
  double px_per_radius = 0.0;
  for (const auto& row : rows)
    px_per_radius += row.J.head<3>().norm() / static_cast<double>(rows.size());
  if (px_per_radius <= 0.0) return Eigen::Matrix3d::Zero();
  const Eigen::Vector3d sight =
      T_camera_centre.linear().transpose() * T_camera_centre.translation().normalized();
  return std::pow(kLightPx / px_per_radius, 2) *
         (Eigen::Matrix3d::Identity() - sight * sight.transpose());
}

double trustOf(double wall_px, double reach_px) {
  const bool clear = wall_px < kWallUnseenPx || wall_px > reach_px + kWallBeyondReachPx;
  return clear ? 1.0 : kTrustNarrowWall;
}

std::vector<Row> associate(const EdgeMap& edges, const Camera& camera,
                           const std::vector<LocalPoint>& points, const Solid& solid,
                           const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile) {
  const auto at = posePoints(camera, points, solid.radius, T_camera_centre);
  std::vector<EdgeHit> hits;
  findEach(edges, profile, at, &hits);
  std::vector<Row> rows;
  rows.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    PosedPoint p;
    if (!hits[i].found || !pointAt(at, i, &p)) continue;
    rows.push_back({normalJacobian(points[i], p), hits[i].offset_px, p.out_px,
                    trustOf(wallWidth(solid, p.deep_px), profile.reach_px)});
  }
  return rows;
}

namespace {

/// The rows by component, and what they weigh.
class RowLanes {
 public:
  static constexpr int kColumns = 6, kLanes = 16;
  explicit RowLanes(const std::vector<Row>& rows)
      : size_((static_cast<int>(rows.size()) + kLanes - 1) / kLanes * kLanes),
        values_(static_cast<std::size_t>(kKinds * size_), 0.0) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      for (int i = 0; i < kColumns; ++i) at(kJacobian + i)[k] = rows[k].J(i);
      at(kOffset)[k] = rows[k].offset;
      at(kTrust)[k] = rows[k].trust;
    }
  }
  /// Tukey's biweight.
  NormalEquations equationsAt(const Vector6d& xi, double tukey_px);

 private:
  enum {
    kJacobian,
    kWeighted = kColumns,
    kOffset = 2 * kColumns,
    kTrust,
    kResidual,
    kCost,
    kUsed,
    kKinds
  };
  double* at(int kind) { return values_.data() + kind * size_; }
  int size_;  // rows that weigh nothing fill the last lanes
  std::vector<double> values_;
};

}  // namespace

/// @param rows  the columns of J, then those of J times weight, each `n` rows long
PBP_SIMD
static void weigh(const double* offset, const double* trust, int n, const Vector6d& xi_at,
                  double inv_tukey2, double* rows, double* residual, double* cost, double* used) {
  constexpr int kColumns = RowLanes::kColumns;
  const double x0 = xi_at(0), x1 = xi_at(1), x2 = xi_at(2), x3 = xi_at(3), x4 = xi_at(4),
               x5 = xi_at(5);
  const DoubleVector zero = {}, one = zero + 1.0;
  for (int k = 0; k < n; k += kDoublesOfVector) {
    DoubleVector J0, J1, J2, J3, J4, J5, o, t;
    load(rows + k, &J0);
    load(rows + n + k, &J1);
    load(rows + 2 * n + k, &J2);
    load(rows + 3 * n + k, &J3);
    load(rows + 4 * n + k, &J4);
    load(rows + 5 * n + k, &J5);
    load(offset + k, &o);
    load(trust + k, &t);
    const DoubleVector r = J0 * x0 + J1 * x1 + J2 * x2 + J3 * x3 + J4 * x4 + J5 * x5 - o;
    const DoubleVector e = one - r * r * inv_tukey2;
    const DoubleVector near = e > zero ? e : zero;  // or 0: outlier
    const DoubleVector weight = t * near * near;
    store(r, residual + k);
    store(t * (one - near * near * near), cost + k);
    store(weight > zero ? one : zero, used + k);
    double* const weighted = rows + kColumns * n + k;
    store(weight * J0, weighted);
    store(weight * J1, weighted + n);
    store(weight * J2, weighted + 2 * n);
    store(weight * J3, weighted + 3 * n);
    store(weight * J4, weighted + 4 * n);
    store(weight * J5, weighted + 5 * n);
  }
}

PBP_SIMD
static void sumUp(const double* rows, const double* residual, int n, NormalEquations* out) {
  Columns weighted, J;
  for (int i = 0; i < RowLanes::kColumns; ++i) {
    J[i] = rows + i * n;
    weighted[i] = rows + (RowLanes::kColumns + i) * n;
  }
  addColumns(weighted, J, residual, n, out);
  out->H.triangularView<Eigen::StrictlyUpper>() = out->H.transpose();
}

NormalEquations RowLanes::equationsAt(const Vector6d& xi, double tukey_px) {
  NormalEquations out;
  weigh(at(kOffset), at(kTrust), size_, xi, 1.0 / (tukey_px * tukey_px), at(kJacobian),
        at(kResidual), at(kCost), at(kUsed));
  sumUp(at(kJacobian), at(kResidual), size_, &out);
  out.cost = std::accumulate(at(kCost), at(kCost) + size_, 0.0);
  out.used = static_cast<int>(std::accumulate(at(kUsed), at(kUsed) + size_, 0.0));
  return out;
}

NormalEquations normalEquations(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px) {
  return RowLanes(rows).equationsAt(xi, tukey_px);
}

/// Unless too few edges hold it.
static ImagePose steppedPose(const Vector6d& xi, int used, const Eigen::Isometry3d& T_camera_centre,
                             double radius) {
  ImagePose out;
  out.used = used;
  const bool few = used < kFewEdges;
  out.status = few ? AlignmentStatus::kTooFewEdges : AlignmentStatus::kAligned;
  out.T_camera_centre = few ? T_camera_centre : stepped(T_camera_centre, xi, radius);
  return out;
}

/// @param system  of the rows at xi
static ImagePose imagePoseOf(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px,
                             const NormalEquations& system,
                             const Eigen::Isometry3d& T_camera_centre, double radius) {
  ImagePose out = steppedPose(xi, system.used, T_camera_centre, radius);
  if (out.status != AlignmentStatus::kAligned) return out;
  out.residual_px = robustSpread(rows, xi, tukey_px);
  const Matrix6d H = system.H + kPrior * Matrix6d::Identity();
  const Eigen::LDLT<Matrix6d> solver(H);
  out.covariance = covarianceOf(rows, xi, tukey_px, system.H, solver.solve(Matrix6d::Identity()));
  tellOffset(rows, xi, tukey_px, solver, system.b, &out);
  return out;
}

ImagePose imagePoseAt(const std::vector<Row>& rows, const Vector6d& xi, double tukey_px,
                      const Eigen::Isometry3d& T_camera_centre, double radius) {
  return imagePoseOf(rows, xi, tukey_px, normalEquations(rows, xi, tukey_px), T_camera_centre,
                     radius);
}

/// One association, and where the steps of its robust least squares end.
struct Steps {
  std::vector<Row> rows;
  Minimum<Vector6d> end;
};

static Steps stepsOf(const EdgeMap& edges, const Camera& camera,
                     const std::vector<LocalPoint>& points, const Solid& solid,
                     const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                     double tukey_px) {
  Steps out{associate(edges, camera, points, solid, T_camera_centre, profile), {}};
  LevenbergMarquardtParams params;
  params.evaluations = kEvaluations;
  params.width = params.width_end = tukey_px;
  params.gain_least = kGainLeast * static_cast<double>(out.rows.size());
  RowLanes lanes(out.rows);
  out.end = minimise(
      Vector6d(Vector6d::Zero()), params,
      [&](const Vector6d& at, int, double width) { return lanes.equationsAt(at, width); },
      [](const Vector6d& at, const Vector6d& step) -> Vector6d {
        return (at + step).cwiseMax(-kStepMost).cwiseMin(kStepMost);
      });
  return out;
}

ImagePose stepInImage(const EdgeMap& edges, const Camera& camera,
                      const std::vector<LocalPoint>& points, const Solid& solid,
                      const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                      double tukey_px) {
  const auto end = stepsOf(edges, camera, points, solid, T_camera_centre, profile, tukey_px).end;
  return steppedPose(end.state, end.equations.used, T_camera_centre, solid.radius);
}

/// To the covariance, what is so of one view alone: the shift by the light, and what the outline's
/// points that are not found say of the others.
/// @param points  of the outline, found or not
static void addOfOneView(const std::vector<Row>& rows, std::size_t points, ImagePose* pose) {
  if (pose->status != AlignmentStatus::kAligned) return;
  const double not_found = (static_cast<double>(points) - pose->used) / pose->used;
  pose->covariance.topLeftCorner<3, 3>() += lightVariance(rows, pose->T_camera_centre);
  pose->covariance *= kAllFound + kNotFound * not_found;
}

ImagePose alignInImage(const EdgeMap& edges, const Camera& camera,
                       const std::vector<LocalPoint>& points, const Solid& solid,
                       const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                       double tukey_px) {
  const auto [rows, end] =
      stepsOf(edges, camera, points, solid, T_camera_centre, profile, tukey_px);
  ImagePose out =
      imagePoseOf(rows, end.state, tukey_px, end.equations, T_camera_centre, solid.radius);
  addOfOneView(rows, points.size(), &out);
  return out;
}

ImagePose lookInImage(const EdgeMap& edges, const Camera& camera,
                      const std::vector<LocalPoint>& points, const Solid& solid,
                      const Eigen::Isometry3d& T_camera_centre, const SearchProfile& profile,
                      double tukey_px) {
  const auto rows = associate(edges, camera, points, solid, T_camera_centre, profile);
  ImagePose out = imagePoseAt(rows, Vector6d::Zero(), tukey_px, T_camera_centre, solid.radius);
  addOfOneView(rows, points.size(), &out);
  return out;
}

}  // namespace planar_bin_picking
