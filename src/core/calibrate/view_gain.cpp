// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/view_gain.h"

#include "calibrate/hand_eye/normal_equations.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;

double uniform(double min, double max, std::mt19937* random) {
  return min + (max - min) * static_cast<double>((*random)()) / 4294967295.0;
}

/// RMS error of a part's position and rotation, and of the camera's own place.
std::array<double, 4> errorsOf(const ErrorModel& model, const Eigen::MatrixXd& covariance) {
  const ExpectedError part = model.of(covariance);
  const auto camera = [&covariance](Eigen::Index at) {
    return std::sqrt(covariance.block<3, 3>(at, at).trace());
  };
  return {part.metres, part.radians, camera(kHandEye), camera(kHandEye + 3)};
}

Eigen::Vector3d centreOf(const Board& board) { return 0.5 * board.corner(board.size() - 1); }

}  // namespace

ViewGain::ViewGain(const HandEyeProblem& problem, const HandEyeResult& solution, double margin_px,
                   double caution)
    : problem_(problem),
      chain_(chainOf(problem, solution)),
      model_(chain_, problem.width, problem.height, solution.working_distance),
      margin_px_(margin_px),
      caution_(caution),
      points_(problem.board.points()) {
  options_.fixed_camera = problem.camera.has_value();
  // A handful of views may fit by chance: no robot and no corner is taken for better than this.
  noise_.pixel = std::max(0.05, solution.sigma_px);
  noise_.robot_t = std::max(5e-5, 1e-3 * solution.robot_mm);
  noise_.robot_r = std::max(1e-4, kPi / 180.0 * solution.robot_deg);
  information_ = Eigen::MatrixXd::Zero(kColumns, kColumns);
  for (std::size_t i = 0; i < solution.views.size(); ++i) {
    if (!solution.views[i].used) continue;
    const Observation& view = problem.observations[i];
    information_ += viewInformation(chain_, noise_, view.points(problem.board), view.T_base_flange);
  }
  if (solution.params.four_axis) {
    const KnownHeight height{centreOf(problem.board), solution.params.board_z,
                             1e-3 * solution.params.board_z_sigma_mm};
    const auto J = height.jacobian(chain_.T_other_board);
    information_.block<6, 6>(kBoard, kBoard) += J.transpose() * J;
  }
  const auto lens = lensPrior(chain_.intrinsics, problem.width, problem.height);
  for (std::size_t i = 0; i < lens.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (lens[i] > 0.0) information_(k, k) += 1.0 / (lens[i] * lens[i]);
  }
  covariance_ =
      invertInformation(information_, options_).value_or(Eigen::MatrixXd::Zero(kColumns, kColumns));
  errors_ = errorsOf(model_, covariance_);
}

Eigen::Vector3d ViewGain::drawCentre(std::mt19937* random) const {
  // From filling the image to a third of it.
  const Board& board = problem_.board;
  const double size = board.square * std::hypot(board.cols, board.rows);
  const double fx = chain_.intrinsics[0], fy = chain_.intrinsics[1], cx = chain_.intrinsics[2],
               cy = chain_.intrinsics[3];
  const double fill = uniform(0.35, 1.0, random);
  const double z = fx * size / (fill * std::min(problem_.width, problem_.height));
  const double u = uniform(0.1, 0.9, random) * problem_.width,
               v = uniform(0.1, 0.9, random) * problem_.height;
  return {z * (u - cx) / fx, z * (v - cy) / fy, z};
}

Eigen::Isometry3d ViewGain::drawUpright(const Eigen::Isometry3d& T_base_start,
                                        std::mt19937* random) const {
  const double yaw = uniform(-1.0, 1.0, random) * (uniform(0.0, 1.0, random) < 0.5 ? 0.6 : 2.5);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * T_base_start.linear();
  const Eigen::Vector3d p_camera = drawCentre(random);
  const Eigen::Vector3d p_other = chain_.T_other_board * centreOf(problem_.board);
  const Eigen::Vector3d p_mount = chain_.T_mount_camera * p_camera;
  return chain_.mounting == Mounting::kEyeInHand ? rigid(R, p_other - R * p_mount)
                                                 : rigid(R, p_mount - R * p_other);
}

Eigen::Isometry3d ViewGain::draw(double tilt_max, const Eigen::Isometry3d& T_base_start,
                                 std::mt19937* random) const {
  const double axis = uniform(-kPi, kPi, random), tilt = uniform(0.0, tilt_max, random);
  // About the optical axis: as at the start, give or take what most robots can turn.
  const Eigen::Matrix3d at_start = chain_.cameraBoard(T_base_start).linear();
  const double yaw0 = std::atan2(at_start(1, 0), at_start(0, 0));
  const double yaw =
      yaw0 + uniform(-1.0, 1.0, random) * (uniform(0.0, 1.0, random) < 0.5 ? 0.6 : 2.5);
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0.0)) *
       Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  const Eigen::Vector3d centre = drawCentre(random);
  const Eigen::Isometry3d T_camera_board = rigid(R, centre - R * centreOf(problem_.board));
  return chain_.mounting == Mounting::kEyeInHand
             ? chain_.T_other_board * T_camera_board.inverse() * chain_.T_mount_camera.inverse()
             : chain_.T_mount_camera * T_camera_board * chain_.T_other_board.inverse();
}

bool ViewGain::surelySeen(const Eigen::Isometry3d& T_base_flange) const {
  const Eigen::Isometry3d T_camera_board = chain_.cameraBoard(T_base_flange);
  // Seen from the front, and not too flat.
  if (!(T_camera_board.linear()(2, 2) > 0.5)) return false;
  // Most draws fail without any uncertainty; derivatives cost more.
  const auto seen = predict(chain_, T_base_flange, Increment(), points_, false);
  if (!seen) return false;
  for (Eigen::Index i = 0; i < seen->pixels.size(); ++i) {
    const int size = i % 2 == 0 ? problem_.width : problem_.height;
    if (!(seen->pixels[i] > margin_px_ && seen->pixels[i] < size - 1 - margin_px_)) return false;
  }
  const auto prediction = predict(chain_, T_base_flange, Increment(), points_, true);
  if (!prediction) return false;
  const auto cols = static_cast<std::size_t>(problem_.board.cols);
  for (const std::size_t i :
       {std::size_t{0}, cols - 1, problem_.board.size() - cols, problem_.board.size() - 1}) {
    const auto at = 2 * static_cast<Eigen::Index>(i);
    const Eigen::MatrixXd J = prediction->shared.middleRows<2>(at);
    const Eigen::Matrix2d spread = J * covariance_ * J.transpose();
    // A square more than the corner itself.
    const double square_px =
        chain_.intrinsics[0] * problem_.board.square / T_camera_board.translation().z();
    const double margin =
        margin_px_ + square_px + 3.0 * caution_ * std::sqrt(spread.diagonal().maxCoeff());
    const Eigen::Vector2d p = prediction->pixels.segment<2>(at);
    if (!(p.x() > margin && p.x() < problem_.width - 1 - margin)) return false;
    if (!(p.y() > margin && p.y() < problem_.height - 1 - margin)) return false;
  }
  return true;
}

std::optional<double> ViewGain::errorAfter(const Eigen::Isometry3d& T_base_flange) const {
  if (!surelySeen(T_base_flange)) return std::nullopt;
  const auto covariance = invertInformation(
      information_ + viewInformation(chain_, noise_, points_, T_base_flange), options_);
  if (!covariance) return std::nullopt;
  const std::array<double, 4> errors = errorsOf(model_, *covariance);
  double sum = 0.0;
  for (std::size_t i = 0; i < errors.size(); ++i) sum += errors[i] / std::max(1e-9, errors_[i]);
  return sum;
}

}  // namespace planar_bin_picking
