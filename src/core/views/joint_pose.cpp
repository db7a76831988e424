// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "views/joint_pose.h"

#include "views/camera_errors.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Wide to narrow: how far edges are sought, and Tukey's width, pixels.
struct Pass {
  SearchProfile profile;
  double tukey_px;
  bool fine;
};
constexpr std::array<Pass, 6> kPasses = {{{{12, false, 1.2}, 12.0, false},
                                          {{10, false, 1.2}, 7.0, false},
                                          {{8, false, 1.2}, 4.0, false},
                                          {{4, true, 0.8}, 3.0, true},
                                          {{4, true, 0.8}, 2.0, true},
                                          {{4, true, 0.8}, 2.0, true}}};
constexpr int kSteps = 3;  // of reweighting within one association

/// A step within one association moves no point farther than this many radii or radians: beyond,
/// the projection is no longer linear and the edges found are others.
constexpr double kStepMost = 0.15;

/// Edge offsets, metres: that of all views may be this far from the expected one, and each view's
/// from that of all.
constexpr double kOffsetSigma = 0.05e-3, kOffsetSpread = 0.03e-3;
constexpr double kOffsetOpen = 1.0;  // radii: where a view cannot tell it
/// A deburred edge is broken by some 0.15 mm, and seen anywhere on the break: the standard
/// deviation of an even distribution. Within its plane a part lies in the middle between two
/// opposite edges, each with its own light. In depth facePose is off by twice as much: a point of
/// the break lies the deeper the less it is inside.
constexpr double kBreakSigma = 0.15e-3 * 0.2887;
constexpr double kMiddleSigma = 0.7071 * kBreakSigma, kHeightSigma = 2.0 * kBreakSigma;
/// A fiftieth of a pixel over the whole outline is never beaten, whatever the edges say.
constexpr double kFloorPx = 0.02;

double meanOffset(const JointState& state) {
  double sum = 0.0;
  for (const double offset : state.offsets) sum += offset;
  return sum / static_cast<double>(state.offsets.size());
}

}  // namespace

Said saidBy(const std::vector<AlignmentRow>& rows, const Vector6d& xi, double tukey_px,
            double radius) {
  const NormalEquations here = normalEquations(rows, xi, tukey_px);
  Said said;
  said.used = here.used;
  if (here.used < kFewEdges) return said;
  // Its own step by the weights of the joint pose, not sent to where no edge holds it.
  const Vector6d own = xi - (here.H + Matrix6d::Identity()).ldlt().solve(here.b);
  const ImagePose pose = imagePoseAt(rows, own, tukey_px, Eigen::Isometry3d::Identity(), radius);
  if (pose.status != AlignmentStatus::kAligned) return said;
  said.told = true;
  const bool tells_offset = std::isfinite(pose.offset_sigma);
  const double offset = tells_offset ? pose.offset : 0.0;
  const double sigma = tells_offset ? pose.offset_sigma : kOffsetOpen;
  Vector7d follows;
  follows << pose.per_offset, 1.0;
  said.mean << own, 0.0;
  said.mean += offset * follows;
  Matrix7d covariance = sigma * sigma * follows * follows.transpose();
  covariance.topLeftCorner<6, 6>() += pose.covariance;
  said.information = covariance.ldlt().solve(Matrix7d::Identity());
  return said;
}

Eigen::MatrixXd offsetInformation(Eigen::Index views, double radius) {
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd::Constant(views, views, std::pow(kOffsetSigma / radius, 2)) +
      Eigen::MatrixXd::Identity(views, views) * std::pow(kOffsetSpread / radius, 2);
  return covariance.ldlt().solve(Eigen::MatrixXd::Identity(views, views));
}

Eigen::Isometry3d facePose(const JointState& state, Face face, double radius) {
  const double height = radius * std::max(0.0, meanOffset(state));
  return state.T_first_centre *
         Eigen::Translation3d(0.0, 0.0, face == Face::kFront ? height : -height);
}

Matrix6d faceCovariance(const Eigen::MatrixXd& covariance, Eigen::Index offsets, Face face) {
  Eigen::MatrixXd by = Eigen::MatrixXd::Zero(6, covariance.cols());
  by.leftCols<6>().setIdentity();
  by.row(2).tail(offsets).setConstant((face == Face::kFront ? 1.0 : -1.0) /
                                      static_cast<double>(offsets));
  return by * covariance * by.transpose();
}

Matrix6d leastCovariance(double radius, double depth, double focal_px) {
  const double in_pixels = kFloorPx * depth / (focal_px * radius);
  Vector6d out = Vector6d::Constant(in_pixels * in_pixels);
  out.head<2>().array() += std::pow(kMiddleSigma / radius, 2);
  out(2) += std::pow(kHeightSigma / radius, 2);
  return out.asDiagonal();
}

Eigen::Isometry3d viewPose(const JointState& state, const std::vector<ViewPtr>& views,
                           std::size_t k) {
  return exp(-state.corrections[k]) * views[k]->T_first_this().inverse() * state.T_first_centre;
}

Matrix6d stepByCorrection(const Eigen::Isometry3d& T_view_centre, double radius) {
  Matrix6d out = -adjoint(T_view_centre.inverse());
  out.topRows<3>() /= radius;
  return out;
}

/// The rows of all views, and where in their own steps and offsets the joint pose is by now.
struct JointAlignment::Association {
  std::vector<std::vector<AlignmentRow>> rows;
  std::vector<Matrix6d> by_correction;
};

JointAlignment::JointAlignment(const SeenPart& seen, const std::vector<ViewPtr>& views,
                               double offset, const ViewsParams& params)
    : seen_(seen), views_(views), expected_(offset / seen.solid.radius) {
  std::vector<Eigen::Isometry3d> others;
  for (const auto& view : views) {
    edges_.push_back(edgesOf(*view));
    if (view != views.front()) others.push_back(view->T_first_this());
  }
  const Eigen::MatrixXd covariance =
      correctionCovariance(others, params, views.front()->camera().model().fx);
  corrections_ =
      covariance.ldlt().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
  offsets_ = offsetInformation(static_cast<Eigen::Index>(views.size()), seen.solid.radius);
}

JointState JointAlignment::startAt(const Eigen::Isometry3d& T_first_centre) const {
  return {T_first_centre, std::vector<Vector6d>(views_.size(), Vector6d::Zero()),
          std::vector<double>(views_.size(), expected_)};
}

JointAlignment::Association JointAlignment::associateAll(const JointState& at, int pass) const {
  const Pass& p = kPasses[static_cast<std::size_t>(pass)];
  Association found;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const Eigen::Isometry3d T = viewPose(at, views_, k);
    const auto points = inward(p.fine ? seen_.fine : seen_.coarse, at.offsets[k]);
    found.rows.push_back(
        associate(edges_[k], views_[k]->camera(), points, seen_.solid, T, p.profile));
    found.by_correction.push_back(stepByCorrection(T, seen_.solid.radius));
  }
  return found;
}

/// The linear problem about one state. Unknowns: xi, the corrections of all views but the first,
/// the offsets of all.
struct JointAlignment::System {
  Eigen::MatrixXd prior, H;       // information
  Eigen::VectorXd b, from_prior;  // of the state about which it is linear
  std::vector<Said> said;
  std::vector<Eigen::Matrix<double, 7, Eigen::Dynamic>> maps;  // unknowns -> a view's own step
};

JointAlignment::System JointAlignment::systemAt(const JointState& start,
                                                const Association& found) const {
  const auto views = static_cast<Eigen::Index>(views_.size());
  const Eigen::Index n = 7 * views, first_offset = 6 * views;
  System system;
  system.prior = Eigen::MatrixXd::Zero(n, n);
  system.prior.block(6, 6, 6 * (views - 1), 6 * (views - 1)) = corrections_;
  system.prior.block(first_offset, first_offset, views, views) = offsets_;
  system.from_prior = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < views; ++k) {
    const auto i = static_cast<std::size_t>(k);
    Eigen::Matrix<double, 7, Eigen::Dynamic> map = Eigen::MatrixXd::Zero(7, n);
    map.topLeftCorner<6, 6>().setIdentity();
    map(6, first_offset + k) = 1.0;
    if (k > 0) {
      map.block<6, 6>(0, 6 * k) = found.by_correction[i];
      system.from_prior.segment<6>(6 * k) = start.corrections[i];
    }
    system.from_prior(first_offset + k) = start.offsets[i] - expected_;
    system.maps.push_back(map);
  }
  return system;
}

void JointAlignment::weigh(const Association& found, const Eigen::VectorXd& x, double tukey_px,
                           System* system) const {
  system->H = system->prior;
  system->b = -system->prior * system->from_prior;
  system->said.clear();
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const auto& map = system->maps[k];
    const Vector7d at = map * x;
    auto rows = found.rows[k];
    // An outline that lies farther in finds its edges farther out.
    for (AlignmentRow& row : rows) row.offset += row.out_px * at(6);
    Said said = saidBy(rows, at.head<6>(), tukey_px, seen_.solid.radius);
    said.mean(6) += at(6);
    if (said.told) {
      system->H += map.transpose() * said.information * map;
      system->b += map.transpose() * (said.information * said.mean);
    }
    system->said.push_back(said);
  }
  system->H.topLeftCorner<6, 6>() += Matrix6d::Identity();  // within a radius and a radian
}

JointPose JointAlignment::solve(const JointState& start, const Association& found,
                                double tukey_px) const {
  System system = systemAt(start, found);
  const auto views = static_cast<Eigen::Index>(views_.size());
  const Eigen::Index n = system.prior.rows();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  JointPose out;
  for (int step = 0; step < kSteps; ++step) {
    weigh(found, x, tukey_px, &system);
    const Eigen::LDLT<Eigen::MatrixXd> solver(system.H);
    x = solver.solve(system.b).cwiseMax(-kStepMost).cwiseMin(kStepMost);
    if (step + 1 < kSteps) continue;
    const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(n, n));
    out.covariance = faceCovariance(covariance, views, seen_.face);
  }
  const Eigen::VectorXd from_prior = x + system.from_prior;
  out.chi_squared = from_prior.dot(system.prior * from_prior);
  out.freedom = -6;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const Said& said = system.said[k];
    out.used.push_back(said.used);
    if (!said.told) continue;
    const Vector7d off = said.mean - system.maps[k] * x;
    out.chi_squared += off.dot(said.information * off);
    out.freedom += 7;
  }
  out.state = start;
  out.state.T_first_centre = stepped(start.T_first_centre, x.head<6>(), seen_.solid.radius);
  for (Eigen::Index k = 0; k < views; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (k > 0) out.state.corrections[i] += x.segment<6>(6 * k);
    out.state.offsets[i] += x(6 * views + k);
  }
  return out;
}

JointPose JointAlignment::align(const JointState& start) const {
  JointPose pose;
  pose.state = start;
  for (std::size_t pass = 0; pass < kPasses.size(); ++pass) {
    pose =
        solve(pose.state, associateAll(pose.state, static_cast<int>(pass)), kPasses[pass].tukey_px);
  }
  pose.covariance +=
      leastCovariance(seen_.solid.radius, pose.state.T_first_centre.translation().z(),
                      views_.front()->camera().model().fx);
  return pose;
}

}  // namespace planar_bin_picking
