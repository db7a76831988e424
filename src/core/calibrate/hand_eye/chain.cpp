// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/chain.h"

#include <ceres/jet.h>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr int kMotions = 18;  // mount_camera, other_board, correction
using Jet = ceres::Jet<double, kMotions>;

template <class T>
struct Motion {
  Eigen::Matrix<T, 3, 3> R;
  Eigen::Matrix<T, 3, 1> t;

  Motion operator*(const Motion& o) const { return {R * o.R, R * o.t + t}; }
  Motion inverse() const { return {R.transpose(), -(R.transpose() * t)}; }
};

template <class T>
Motion<T> fixed(const Eigen::Isometry3d& T_) {
  return {T_.linear().cast<T>(), T_.translation().cast<T>()};
}

template <class T>
Motion<T> small(const Eigen::Matrix<T, 6, 1>& xi) {
  Motion<T> m;
  expSe3<T>(xi, &m.R, &m.t);
  return m;
}

template <class T>
Motion<T> cameraBoard(const Chain& chain, const Eigen::Isometry3d& T_base_flange,
                      const Eigen::Matrix<T, kMotions, 1>& xi) {
  const Motion<T> T_mount_camera =
      fixed<T>(chain.T_mount_camera) * small<T>(xi.template segment<6>(0));
  const Motion<T> T_other_board =
      fixed<T>(chain.T_other_board) * small<T>(xi.template segment<6>(6));
  const Motion<T> T_base_true = fixed<T>(T_base_flange) * small<T>(xi.template segment<6>(12));
  const bool in_hand = chain.mounting == Mounting::kEyeInHand;
  return T_mount_camera.inverse() * (in_hand ? T_base_true.inverse() : T_base_true) * T_other_board;
}

Eigen::Matrix<double, kMotions, 1> stacked(const Increment& increment) {
  Eigen::Matrix<double, kMotions, 1> xi;
  xi << increment.mount_camera, increment.other_board, increment.correction;
  return xi;
}

/// Values and derivatives of the pose camera-board by the 18 motions.
struct PoseDerivative {
  Motion<double> pose;
  Eigen::Matrix<double, 12, kMotions> by_motion;  // rows: R column by column, then t
};

PoseDerivative differentiate(const Chain& chain, const Eigen::Isometry3d& T_base_flange,
                             const Increment& increment) {
  const Eigen::Matrix<double, kMotions, 1> values = stacked(increment);
  Eigen::Matrix<Jet, kMotions, 1> xi;
  for (int i = 0; i < kMotions; ++i) xi[i] = Jet(values[i], i);
  const Motion<Jet> jets = cameraBoard<Jet>(chain, T_base_flange, xi);
  PoseDerivative out;
  for (int k = 0; k < 9; ++k) {
    out.pose.R(k % 3, k / 3) = jets.R(k % 3, k / 3).a;
    out.by_motion.row(k) = jets.R(k % 3, k / 3).v.transpose();
  }
  for (int k = 0; k < 3; ++k) {
    out.pose.t[k] = jets.t[k].a;
    out.by_motion.row(9 + k) = jets.t[k].v.transpose();
  }
  return out;
}

struct Pixel {
  Eigen::Vector2d p_image;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, kHandEye> by_intrinsics;
};

/// Camera's formula, with derivatives by the point and by the intrinsics; it is linear in the
/// latter.
Pixel project(const Chain& chain, const Eigen::Vector3d& p) {
  const auto& [fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6] = chain.intrinsics;
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y, r4 = r2 * r2;
  const double below = 1.0 + k4 * r2 + k5 * r4 + k6 * r4 * r2;
  const double radial = (1.0 + k1 * r2 + k2 * r4 + k3 * r4 * r2) / below;
  const double by_r2 =
      (k1 + 2.0 * k2 * r2 + 3.0 * k3 * r4 - radial * (k4 + 2.0 * k5 * r2 + 3.0 * k6 * r4)) / below;
  const double q2 = r2 / below, q4 = r4 / below, q6 = r4 * r2 / below;
  const double xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const double yd = y * radial + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y);
  Eigen::Matrix2d by_ideal;
  by_ideal << radial + 2.0 * x * x * by_r2 + 2.0 * p1 * y + 6.0 * p2 * x,
      2.0 * (x * y * by_r2 + p1 * x + p2 * y), 2.0 * (x * y * by_r2 + p1 * x + p2 * y),
      radial + 2.0 * y * y * by_r2 + 6.0 * p1 * y + 2.0 * p2 * x;
  Eigen::Matrix<double, 2, 3> ideal_by_point;
  ideal_by_point << 1.0, 0.0, -x, 0.0, 1.0, -y;
  Pixel out;
  out.p_image = {fx * xd + cx, fy * yd + cy};
  out.by_point = Eigen::Vector2d(fx, fy).asDiagonal() * by_ideal * ideal_by_point / p.z();
  // By k4 k5 k6 the numerator stays, and what is below it grows.
  const double n2 = -radial * q2, n4 = -radial * q4, n6 = -radial * q6;
  out.by_intrinsics << xd, 0.0, 1.0, 0.0, fx * x * q2, fx * x * q4, fx * 2.0 * x * y,
      fx * (r2 + 2.0 * x * x), fx * x * q6, fx * x * n2, fx * x * n4, fx * x * n6,  //
      0.0, yd, 0.0, 1.0, fy * y * q2, fy * y * q4, fy * (r2 + 2.0 * y * y), fy * 2.0 * x * y,
      fy * y * q6, fy * y * n2, fy * y * n4, fy * y * n6;
  return out;
}

/// A corner this near to the camera's plane has no image.
constexpr double kNearest = 1e-3;

}  // namespace

Eigen::Isometry3d Chain::cameraBoard(const Eigen::Isometry3d& T_base_flange) const {
  const bool in_hand = mounting == Mounting::kEyeInHand;
  return T_mount_camera.inverse() * (in_hand ? T_base_flange.inverse() : T_base_flange) *
         T_other_board;
}

std::optional<Prediction> predict(const Chain& chain, const Eigen::Isometry3d& T_base_flange,
                                  const Increment& increment,
                                  const std::vector<Eigen::Vector3d>& points, bool jacobians) {
  PoseDerivative T_camera_board;
  if (jacobians) {
    T_camera_board = differentiate(chain, T_base_flange, increment);
  } else {
    T_camera_board.pose = cameraBoard<double>(chain, T_base_flange, stacked(increment));
  }
  const double scale = chain.scale * std::exp(increment.log_scale);
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(points.size());
  Prediction out{Eigen::VectorXd(rows), {}, {}};
  if (jacobians) {
    out.shared.resize(rows, kColumns);
    out.correction.resize(rows, 6);
  }
  for (Eigen::Index i = 0; 2 * i < rows; ++i) {
    const Eigen::Vector3d x = scale * points[static_cast<std::size_t>(i)];
    const Eigen::Vector3d turned = T_camera_board.pose.R * x;
    const Eigen::Vector3d p = turned + T_camera_board.pose.t;
    if (!(p.z() > kNearest)) return std::nullopt;
    const Pixel pixel = project(chain, p);
    out.pixels.segment<2>(2 * i) = pixel.p_image;
    if (!jacobians) continue;
    Eigen::Matrix<double, 3, kMotions> by_motion = T_camera_board.by_motion.bottomRows<3>();
    for (int k = 0; k < 3; ++k) by_motion += x[k] * T_camera_board.by_motion.middleRows<3>(3 * k);
    const Eigen::Matrix<double, 2, kMotions> m = pixel.by_point * by_motion;
    out.shared.block<2, kHandEye>(2 * i, kIntrinsics) = pixel.by_intrinsics;
    out.shared.block<2, 12>(2 * i, kHandEye) = m.leftCols<12>();
    out.shared.block<2, 1>(2 * i, kScale) = pixel.by_point * turned;
    out.correction.middleRows<2>(2 * i) = m.rightCols<6>();
  }
  return out;
}

SeenPoints seenPoints(const Board& board, const Observation& observation) {
  return {observation.points(board), observation.corners};
}

std::vector<Eigen::Vector2d> residuals(const Chain& chain, const Board& board,
                                       const Observation& observation, const Vector6d& correction) {
  Increment increment;
  increment.correction = correction;
  const auto prediction =
      predict(chain, observation.T_base_flange, increment, observation.points(board), false);
  std::vector<Eigen::Vector2d> out;
  if (!prediction) return out;
  for (std::size_t i = 0; i < observation.corners.size(); ++i) {
    out.push_back(observation.corners[i] -
                  prediction->pixels.segment<2>(2 * static_cast<Eigen::Index>(i)));
  }
  return out;
}

Camera::Model toModel(const Intrinsics& intrinsics, int width, int height) {
  Camera::Model model;
  model.width = width;
  model.height = height;
  model.fx = intrinsics[0];
  model.fy = intrinsics[1];
  model.cx = intrinsics[2];
  model.cy = intrinsics[3];
  const auto denominator = intrinsics.begin() + kDenominator;
  const bool is_rational =
      std::any_of(denominator, intrinsics.end(), [](double k) { return k != 0.0; });
  if (is_rational) model.distortion_model = "rational_polynomial";
  model.distortion.assign(intrinsics.begin() + 4, is_rational ? intrinsics.end() : denominator);
  return model;
}

Intrinsics fromModel(const Camera::Model& model) {
  Intrinsics intrinsics{model.fx, model.fy, model.cx, model.cy};
  for (std::size_t i = 0; i < 8 && i < model.distortion.size(); ++i) {
    intrinsics[4 + i] = model.distortion[i];
  }
  return intrinsics;
}

Chain chainOf(const HandEyeProblem& problem, const HandEyeResult& solution) {
  Chain chain;
  chain.mounting = problem.mounting;
  chain.intrinsics = fromModel(solution.camera);
  chain.T_mount_camera = solution.T_mount_camera;
  chain.T_other_board = solution.T_other_board;
  return chain;
}

double rms(const std::vector<Eigen::Vector2d>& residuals) {
  double sum = 0.0;
  for (const Eigen::Vector2d& r : residuals) sum += r.squaredNorm();
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

Chain moved(const Chain& chain, const Increment& increment) {
  Chain out = chain;
  out.T_mount_camera = chain.T_mount_camera * exp(increment.mount_camera);
  out.T_other_board = chain.T_other_board * exp(increment.other_board);
  out.scale = chain.scale * std::exp(increment.log_scale);
  return out;
}

Intrinsics lensPrior(const Intrinsics& intrinsics, int width, int height, LensFreedom freedom) {
  const double r = 0.5 * std::hypot(width, height) / intrinsics[0], r2 = r * r;
  // Shares of the distance of the image's corner from its centre: a strong lens has 0.3 in all.
  constexpr double kRadial = 0.3, kTangential = 0.02;
  // What is held this firmly moves no corner by a hundredth of a pixel.
  constexpr double kHeld = 1e-5;
  const bool is_free = freedom == LensFreedom::kFull || freedom == LensFreedom::kRational;
  const double k1 = is_free ? 1.0 : freedom == LensFreedom::kNone ? kHeld : 0.1;
  const double others = freedom == LensFreedom::kFirstRadial ? kHeld : k1;
  const double below = freedom == LensFreedom::kRational ? k1 : kHeld;
  const double r4 = r2 * r2, r6 = r4 * r2;
  return {0.0,
          0.0,
          0.0,
          0.0,
          k1 * kRadial / r2,
          others * kRadial / r4,
          others * kTangential / r,
          others * kTangential / r,
          others * kRadial / r6,
          below * kRadial / r2,
          below * kRadial / r4,
          below * kRadial / r6};
}

}  // namespace planar_bin_picking
