// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_run.h"

#include "calibrate/hand_eye/bundle_adjustment.h"
#include "calibrate/hand_eye/observation_check.h"
#include "calibrate/hand_eye/verdict.h"
#include "calibrate/view_gain.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
/// So many views, turned about two axes, give a provisional solution.
constexpr std::size_t kFirstViews = 5;
constexpr double kFirstShift = 0.02;  // metres
/// Where a robot turns about one axis alone, the shifts tell how the camera is turned about it.
constexpr double kFirstShiftUpright = 0.04;
/// Turns of the first moves, about the flange's x, y and z.
const double kFirstTurns[][3] = {{1, 0, 0},  {0, 1, 0},   {0, 0, 2},  {-1, 0, 0}, {0, -1, 0},
                                 {0, 0, -2}, {1, 1, 1},   {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1},
                                 {1, 0, 2},  {-1, 0, -2}, {0, 1, 2},  {0, -1, -2}};
constexpr int kFirstMoves = static_cast<int>(std::size(kFirstTurns));
/// Who adds to an earlier run wants at least so many.
constexpr int kMoreViews = 3;
/// Two pictures from poses that differ by less are one: below what a robot repeats, or near it.
constexpr double kSameMetres = 5e-4, kSameRadians = 0.05 * kRadians;
/// What lies nearer to a pose that the robot refused is not tried: as a pose for a picture, and on
/// the way to one.
constexpr double kSamePoseMetres = 0.03, kSamePoseRadians = 6.0 * kRadians;
constexpr double kSameWayMetres = 0.005, kSameWayRadians = 1.0 * kRadians;
/// Standard deviations that a place is expected to keep.
constexpr double kSure = 3.0;

bool isNear(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double metres, double radians) {
  const Eigen::Isometry3d between = a.inverse() * b;
  return between.translation().norm() < metres && rotationAngle(between.linear()) < radians;
}

Eigen::Matrix3d turnedAboutZ(double angle, const Eigen::Isometry3d& T_base_flange) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
         T_base_flange.linear();
}

double largestSigma(const SharedMatrix& covariance, Eigen::Index at) {
  const Eigen::Matrix3d block = covariance.block<3, 3>(at, at);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(block, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

/// The camera, or the outer corners of the board's outermost squares.
Mounted mountedOf(const HandEyeProblem& problem, const HandEyeResult& solution, double clearance) {
  Mounted mounted;
  mounted.margin = clearance;
  if (problem.mounting == Mounting::kEyeInHand) {
    mounted.points = {solution.T_mount_camera.translation()};
    mounted.margin += kSure * largestSigma(solution.covariance, kHandEye);
    return mounted;
  }
  const Board& board = problem.board;
  mounted.points.clear();
  double reach = 0.0;
  for (const int col : {-1, board.cols}) {
    for (const int row : {-1, board.rows}) {
      const Eigen::Vector3d corner(board.square * col, board.square * row, 0.0);
      mounted.points.emplace_back(solution.T_other_board * corner);
      reach = std::max(reach, corner.norm());
    }
  }
  mounted.margin += kSure * (largestSigma(solution.covariance, kBoard) +
                             reach * largestSigma(solution.covariance, kBoard + 3));
  return mounted;
}

}  // namespace

void validate(const RunParams& params) {
  const auto refuse = [](const std::string& key, double value, const std::string& expected) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << key << " is " << value << ", must be " << expected;
    throw std::invalid_argument(text.str());
  };
  RunParams::fields(params, [&](const std::string& key, const auto& value, auto min, auto max) {
    if (value >= min && value <= max) return;
    std::ostringstream range;
    range.imbue(std::locale::classic());
    range << "between " << min << " and " << max;
    refuse(key, value, range.str());
  });
  validate(params.motion);
}

CalibrationRun::CalibrationRun(const HandEyeProblem& problem, const HandEyeParams& solver,
                               const RunParams& params, const Eigen::Isometry3d& T_base_start)
    : problem_(problem),
      solver_(solver),
      params_(params),
      T_base_start_(T_base_start),
      limits_(params.motion, T_base_start),
      T_base_here_(T_base_start),
      earlier_views_(problem.observations.size()),
      random_(static_cast<unsigned>(params.seed)),
      turn_(params.first_turn_deg * kRadians) {
  validate(problem_);
  validate(solver_);
  validate(params_);
  update();
}

bool CalibrationRun::isNearRefused(const Eigen::Isometry3d& T_base_flange, double metres,
                                   double radians) const {
  return std::any_of(refused_.begin(), refused_.end(), [&](const Eigen::Isometry3d& other) {
    return isNear(other, T_base_flange, metres, radians);
  });
}

bool CalibrationRun::findWay(const Eigen::Isometry3d& T_base_target) {
  auto way = limits_.way(T_base_here_, T_base_target);
  if (!way) return false;
  // What was refused once is not asked for again.
  for (const Eigen::Isometry3d& pose : *way) {
    if (isNearRefused(pose, kSameWayMetres, kSameWayRadians)) return false;
  }
  way_ = std::move(*way);
  return true;
}

bool CalibrationRun::headBack() {
  way_.clear();
  auto way = limits_.way(T_base_here_, T_base_start_);
  if (way) way_ = std::move(*way);
  return way.has_value();
}

std::optional<Eigen::Isometry3d> CalibrationRun::step() {
  if (way_.empty()) return std::nullopt;
  if (!limits_.allowsStep(T_base_here_, way_.front())) {
    // The robot does not stand quite where it was sent: from there another way may be needed.
    const auto way = limits_.way(T_base_here_, way_.back());
    if (!way || way->empty()) return std::nullopt;
    way_ = *way;
  }
  return way_.front();
}

void CalibrationRun::arrived(const Eigen::Isometry3d& T_base_flange) {
  const std::string reason = limits_.whyNot(T_base_flange);
  if (!reason.empty()) throw std::runtime_error("the robot went too far: " + reason);
  T_base_here_ = T_base_flange;
  if (!way_.empty()) way_.erase(way_.begin());
  refusals_ = 0;
}

CalibrationRun::End CalibrationRun::whyEnough() const {
  const auto views = static_cast<int>(problem_.observations.size() - earlier_views_);
  if (refusals_ >= params_.refusals_max) return End::kRefusals;
  if (attempts_ >= params_.attempts_max) return End::kAttempts;
  if (views >= params_.views_max) return End::kViews;
  const bool may_end = earlier_views_ == 0 || views >= kMoreViews;
  if (may_end && solution_ && solution_->views_used >= solver_.min_views &&
      solution_->expected_error_mm <= solver_.tolerance_mm &&
      solution_->expected_error_deg <= solver_.tolerance_deg) {
    return End::kGood;
  }
  return End::kNone;
}

std::optional<Eigen::Isometry3d> CalibrationRun::next() {
  end_ = whyEnough();
  if (end_ != End::kNone) return std::nullopt;
  std::optional<Eigen::Isometry3d> move;
  is_large_ = false;
  way_.clear();
  if (attempts_ == 0) {
    move = T_base_start_;
  } else {
    if (solution_) move = bestMove();
    // Where the solution is still too vague for a large move, small ones go on.
    is_large_ = move.has_value();
    if (!move) move = firstMove();
  }
  if (!move) {
    end_ = End::kNoPose;
    return std::nullopt;
  }
  ++attempts_;
  poses_.push_back({*move, PlannedPose::State::kPlanned});
  return move;
}

std::optional<Eigen::Isometry3d> CalibrationRun::firstMove() {
  // A few times round: with smaller turns where the board was lost.
  while (first_moves_ < 3 * kFirstMoves) {
    const double* const turns = kFirstTurns[first_moves_++ % kFirstMoves];
    const Eigen::Vector3d w = turn_ * Eigen::Vector3d(turns[0], turns[1], turns[2]);
    const double shift = solver_.four_axis ? kFirstShiftUpright : kFirstShift;
    Vector6d xi = Vector6d::Zero();
    xi.tail<3>() = w;
    // A little aside, too: places about the start that cannot be reached lie next to each other.
    for (int i = 0; i < 3; ++i) {
      xi[i] = shift * (2.0 * static_cast<double>(random_()) / 4294967295.0 - 1.0);
    }
    Eigen::Isometry3d move = T_base_start_ * exp(xi);
    if (solver_.four_axis) move.linear() = turnedAboutZ(w.sum(), T_base_start_);
    if (limits_.allowsTarget(move) && findWay(move)) return move;
  }
  return std::nullopt;
}

std::optional<Eigen::Isometry3d> CalibrationRun::bestMove() {
  const ViewGain gain(problem_, *solution_, params_.margin_px, caution_);
  std::optional<Eigen::Isometry3d> best;
  double best_error = 0.0;
  // Where the solution is vague few candidates are sure to show the board: draw more of them.
  int left = params_.candidates;
  for (int draw = 0; draw < 20 * params_.candidates && left > 0; ++draw) {
    const Eigen::Isometry3d move =
        solver_.four_axis ? gain.drawUpright(T_base_start_, &random_)
                          : gain.draw(params_.tilt_max_deg * kRadians, T_base_start_, &random_);
    if (!limits_.allowsTarget(move) || isNearRefused(move, kSamePoseMetres, kSamePoseRadians))
      continue;
    const auto error = gain.errorAfter(move);
    if (!error) continue;
    --left;
    if (best && !(*error < best_error)) continue;
    if (!findWay(move)) continue;
    best = move;
    best_error = *error;
  }
  return best;
}

void CalibrationRun::refused(const Eigen::Isometry3d& T_base_flange) {
  poses_.back().state = PlannedPose::State::kRefused;
  refused_.push_back(T_base_flange);
  ++refusals_;
}

void CalibrationRun::lost() {
  poses_.back().state = PlannedPose::State::kLost;
  refused_.push_back(poses_.back().T_base_flange);
  turn_ *= 0.7;
  caution_ *= 1.3;
}

bool CalibrationRun::isKnown(const Eigen::Isometry3d& T_base_flange) const {
  return std::any_of(problem_.observations.begin(), problem_.observations.end(),
                     [&](const Observation& other) {
                       return isNear(other.T_base_flange, T_base_flange, kSameMetres, kSameRadians);
                     });
}

void CalibrationRun::seen(const Observation& observation) {
  poses_.back().state = PlannedPose::State::kSeen;
  if (isKnown(observation.T_base_flange)) return;
  problem_.observations.push_back(observation);
  update();
}

void CalibrationRun::update() {
  if (problem_.observations.size() < kFirstViews) return;
  // Scale and leave-one-out are checked at the end alone.
  HandEyeParams provisional = solver_;
  provisional.min_views = 1000;
  const HandEyeResult solution = solveHandEye(problem_, provisional);
  const bool is_turned = solver_.four_axis || solution.axes_deg > 0.2 * params_.first_turn_deg;
  if (!solution.solved || !is_turned) return;
  solution_ = solution;
  updateMounted();
}

void CalibrationRun::updateMounted() {
  const Mounted known = mountedOf(problem_, *solution_, params_.motion.clearance_m);
  const double radius = params_.motion.mounted_radius_m;
  double reach = 0.0;
  for (const Eigen::Vector3d& point : known.points) reach = std::max(reach, point.norm());
  const double doubt = known.margin - params_.motion.clearance_m;
  if (reach - doubt > radius) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(2);
    text << (problem_.mounting == Mounting::kEyeInHand ? "the camera" : "the board") << " reaches "
         << reach << " m from the flange, and mounted_radius_m is " << radius
         << "; measure it and correct mounted_radius_m";
    throw std::runtime_error(text.str());
  }
  // Doubt is no reason to be less careful than before, nor to leave where the robot may stand.
  MotionLimits limits = limits_;
  limits.setMounted(known);
  const bool is_better = doubt + params_.motion.clearance_m < radius &&
                         limits.allows(T_base_here_) && limits.allows(T_base_start_);
  limits_.setMounted(is_better ? known : Mounted{{Eigen::Vector3d::Zero()}, radius});
}

}  // namespace planar_bin_picking
