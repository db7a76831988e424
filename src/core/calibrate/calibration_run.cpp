// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_run.h"

#include "calibrate/hand_eye/bundle_adjustment.h"
#include "calibrate/hand_eye/observation_check.h"
#include "calibrate/hand_eye/verdict.h"
#include "calibrate/view_gain.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
/// So many views, turned about two axes, give a provisional solution.
constexpr std::size_t kFirstViews = 5;
constexpr double kFirstShift = 0.02;  // metres
/// Turns of the first moves, about the flange's x, y and z.
const double kFirstTurns[][3] = {{1, 0, 0},  {0, 1, 0},   {0, 0, 2},  {-1, 0, 0}, {0, -1, 0},
                                 {0, 0, -2}, {1, 1, 1},   {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1},
                                 {1, 0, 2},  {-1, 0, -2}, {0, 1, 2},  {0, -1, -2}};
constexpr int kFirstMoves = static_cast<int>(std::size(kFirstTurns));

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
  const auto check = [&](const char* key, double min, double max) {
    if (!(min < max)) refuse(key, max, "greater than its minimum, or the workspace is empty");
  };
  check("workspace_max_x", params.workspace_min_x, params.workspace_max_x);
  check("workspace_max_y", params.workspace_min_y, params.workspace_max_y);
  check("workspace_max_z", params.workspace_min_z, params.workspace_max_z);
}

CalibrationRun::CalibrationRun(const HandEyeProblem& empty, const HandEyeParams& solver,
                               const RunParams& params, const Eigen::Isometry3d& T_base_start)
    : problem_(empty),
      solver_(solver),
      params_(params),
      T_base_start_(T_base_start),
      random_(static_cast<unsigned>(params.seed)),
      turn_(params.first_turn_deg * kRadians) {
  validate(problem_);
  validate(solver_);
  validate(params_);
  if (!allowed(T_base_start)) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << "the robot stands at [" << T_base_start.translation().transpose()
         << "], outside the workspace; move it into it, or change workspace_*";
    throw std::invalid_argument(text.str());
  }
}

bool CalibrationRun::allowed(const Eigen::Isometry3d& T_base_flange) const {
  const Eigen::Array3d p = T_base_flange.translation().array();
  const Eigen::Array3d min(params_.workspace_min_x, params_.workspace_min_y,
                           params_.workspace_min_z);
  const Eigen::Array3d max(params_.workspace_max_x, params_.workspace_max_y,
                           params_.workspace_max_z);
  if (!(p >= min).all() || !(p <= max).all()) return false;
  const double cosine = T_base_flange.linear().col(2).dot(T_base_start_.linear().col(2));
  return std::acos(std::min(1.0, cosine)) <= params_.cone_deg * kRadians;
}

bool CalibrationRun::isNearRefused(const Eigen::Isometry3d& T_base_flange) const {
  constexpr double kMetres = 0.03, kAngle = 6.0 * kRadians;
  for (const Eigen::Isometry3d& other : refused_) {
    const Eigen::Isometry3d between = other.inverse() * T_base_flange;
    if (between.translation().norm() < kMetres && rotationAngle(between.linear()) < kAngle) {
      return true;
    }
  }
  return false;
}

std::optional<Eigen::Isometry3d> CalibrationRun::next() {
  if (static_cast<int>(problem_.observations.size()) >= params_.views_max) return std::nullopt;
  if (attempts_ >= params_.attempts_max) return std::nullopt;
  if (solution_ && solution_->views_used >= solver_.min_views &&
      solution_->expected_error_mm <= solver_.tolerance_mm &&
      solution_->expected_error_deg <= solver_.tolerance_deg) {
    return std::nullopt;
  }
  std::optional<Eigen::Isometry3d> move;
  if (attempts_ == 0) {
    move = T_base_start_;
  } else {
    move = solution_ ? bestMove() : firstMove();
  }
  if (!move) return std::nullopt;
  ++attempts_;
  poses_.push_back({*move, PlannedPose::State::kPlanned});
  return move;
}

std::optional<Eigen::Isometry3d> CalibrationRun::firstMove() {
  // A few times round: with smaller turns where the board was lost.
  while (first_moves_ < 3 * kFirstMoves) {
    const double* const turns = kFirstTurns[first_moves_++ % kFirstMoves];
    const Eigen::Vector3d w = turn_ * Eigen::Vector3d(turns[0], turns[1], turns[2]);
    Vector6d xi = Vector6d::Zero();
    xi.tail<3>() = w;
    // A little aside, too: places about the start that cannot be reached lie next to each other.
    for (int i = 0; i < 3; ++i) {
      xi[i] = kFirstShift * (2.0 * static_cast<double>(random_()) / 4294967295.0 - 1.0);
    }
    const Eigen::Isometry3d move = T_base_start_ * exp(xi);
    if (allowed(move)) return move;
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
        gain.draw(params_.tilt_max_deg * kRadians, T_base_start_, &random_);
    if (!allowed(move) || isNearRefused(move)) continue;
    const auto error = gain.errorAfter(move);
    if (!error) continue;
    --left;
    if (best && !(*error < best_error)) continue;
    best = move;
    best_error = *error;
  }
  return best;
}

void CalibrationRun::refused() {
  poses_.back().state = PlannedPose::State::kRefused;
  refused_.push_back(poses_.back().T_base_flange);
}

void CalibrationRun::lost() {
  poses_.back().state = PlannedPose::State::kLost;
  refused_.push_back(poses_.back().T_base_flange);
  turn_ *= 0.7;
  caution_ *= 1.3;
}

void CalibrationRun::seen(const Observation& observation) {
  poses_.back().state = PlannedPose::State::kSeen;
  problem_.observations.push_back(observation);
  update();
}

void CalibrationRun::update() {
  if (problem_.observations.size() < kFirstViews) return;
  // Scale and leave-one-out are checked at the end alone.
  HandEyeParams provisional = solver_;
  provisional.min_views = 1000;
  const HandEyeResult solution = solveHandEye(problem_, provisional);
  if (solution.solved && solution.axes_deg > 0.2 * params_.first_turn_deg) solution_ = solution;
}

}  // namespace planar_bin_picking
