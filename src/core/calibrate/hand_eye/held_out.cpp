// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/held_out.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// How far a view is off that a solution without it predicts; pixels.
using ViewError = std::function<double(const Adjusted& without, const Observation& view)>;

/// With its robot pose as reported.
ViewError chainError(const HandEyeProblem& problem) {
  return [&problem](const Adjusted& without, const Observation& view) {
    const auto r = residuals(without.chain, problem.board, view, Vector6d::Zero());
    return r.empty() ? problem.width : rms(r);
  };
}

/// With its board placed freely: what the lens leaves.
ViewError lensOnlyError(const HandEyeProblem& problem) {
  return [&problem](const Adjusted& without, const Observation& view) {
    const SeenPoints seen = seenPoints(problem.board, view);
    const auto T_camera_board =
        boardPose(toModel(without.chain.intrinsics, problem.width, problem.height), seen);
    if (!T_camera_board) return 1.0 * problem.width;
    Chain placed = without.chain;
    placed.mounting = Mounting::kEyeToHand;
    placed.T_mount_camera = Eigen::Isometry3d::Identity();
    placed.T_other_board = *T_camera_board;
    Observation still = view;
    still.T_base_flange = Eigen::Isometry3d::Identity();
    const auto r = residuals(placed, problem.board, still, Vector6d::Zero());
    return r.empty() ? problem.width : rms(r);
  };
}

std::vector<double> heldOutErrors(const HeldOut& of, const Adjusted& state,
                                  const AdjustOptions& given, const ViewError& error_of) {
  constexpr std::size_t kFolds = 5;
  AdjustOptions options = given;
  options.rounds = 0;
  std::vector<double> errors(of.views.size(), 0.0);
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    std::vector<const Observation*> views;
    Adjusted start = startAt(state.chain, state.noise, {});
    for (std::size_t i = 0; i < of.views.size(); ++i) {
      if (i % kFolds == fold) continue;
      views.push_back(of.views[i]);
      start.corrections.push_back(state.corrections[i]);
      start.weights.push_back(state.weights[i]);
    }
    const Adjusted without = adjust(of.problem, views, start, options);
    for (std::size_t i = fold; i < of.views.size(); i += kFolds) {
      errors[i] = error_of(without, *of.views[i]);
    }
  }
  return errors;
}

double meanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Whether `errors` are smaller than `reference` by two standard errors and a share of it, view by
/// view.
bool areSurelySmaller(const std::vector<double>& errors, const std::vector<double>& reference,
                      double share) {
  constexpr double kStandardErrors = 2.0;
  std::vector<double> gains;
  for (std::size_t i = 0; i < errors.size(); ++i) gains.push_back(reference[i] - errors[i]);
  const double gain = meanOf(gains);
  double square = 0.0;
  for (const double g : gains) square += (g - gain) * (g - gain);
  const auto n = static_cast<double>(gains.size());
  return gain > kStandardErrors * std::sqrt(square / (n * (n - 1.0))) &&
         gain > share * meanOf(reference);
}

int coefficientsOf(LensFreedom lens) {
  switch (lens) {
    case LensFreedom::kRational:
      return 8;
    case LensFreedom::kFull:
    case LensFreedom::kStiff:
      return 5;
    case LensFreedom::kFirstRadial:
      return 1;
    case LensFreedom::kNone:
      return 0;
  }
  return 0;
}

}  // namespace

double chooseRobotNoise(HeldOut of) {
  const Noise estimated = of.state->noise;
  const ViewError error_of = chainError(of.problem);
  const std::vector<double> reference = heldOutErrors(of, *of.state, *of.options, error_of);
  double held_out_px = meanOf(reference);
  if (of.options->fixed_robot_noise) return held_out_px;
  // The error as the robot reports its poses falls a little with any smaller noise, since that fits
  // these poses more closely; the camera's place need not gain by it.
  constexpr double kShare = 0.25;
  for (const double factor : {0.1, 0.3, 3.0}) {
    Adjusted trial = *of.state;
    trial.noise = estimated;
    trial.noise.robot_t *= factor;
    trial.noise.robot_r *= factor;
    const std::vector<double> errors = heldOutErrors(of, trial, *of.options, error_of);
    if (!areSurelySmaller(errors, reference, kShare) || !(meanOf(errors) < held_out_px)) continue;
    AdjustOptions options = *of.options;
    options.fixed_robot_noise = true;
    trial = adjust(of.problem, of.views, trial, options);
    if (!trial.converged || trial.degenerate || !lensError(of.problem, trial).empty()) continue;
    // What the corners cannot have is the robot's: a smaller noise may not leave it to them.
    constexpr double kCornersAllow = 1.5;
    if (trial.noise.pixel > kCornersAllow * estimated.pixel) continue;
    held_out_px = meanOf(errors);
    *of.state = trial;
  }
  return held_out_px;
}

std::vector<LensTrial> chooseLens(HeldOut of) {
  // A gain that no picture shows is none.
  constexpr double kShare = 0.05;
  const ViewError error_of = lensOnlyError(of.problem);
  const LensFreedom first = of.options->lens;
  std::vector<double> best = heldOutErrors(of, *of.state, *of.options, error_of);
  std::vector<LensTrial> trials{{coefficientsOf(first), meanOf(best), true}};
  std::vector<LensFreedom> others;
  // Where five fold the image over, eight do.
  if (first == LensFreedom::kFull) others = {LensFreedom::kFirstRadial, LensFreedom::kRational};
  for (const LensFreedom lens : others) {
    AdjustOptions options = *of.options;
    options.lens = lens;
    Adjusted start = *of.state;
    if (lens == LensFreedom::kFirstRadial) {
      std::fill(start.chain.intrinsics.begin() + 5, start.chain.intrinsics.end(), 0.0);
    }
    const Adjusted trial = adjust(of.problem, of.views, start, options);
    if (!trial.converged || trial.degenerate || !lensError(of.problem, trial).empty()) continue;
    const std::vector<double> errors = heldOutErrors(of, trial, options, error_of);
    trials.push_back({coefficientsOf(lens), meanOf(errors), false});
    if (!areSurelySmaller(errors, best, kShare)) continue;
    best = errors;
    *of.state = trial;
    *of.options = options;
    for (LensTrial& other : trials) other.is_chosen = false;
    trials.back().is_chosen = true;
  }
  return trials;
}

std::string lensError(const HandEyeProblem& problem, const Adjusted& state) {
  try {
    const Camera checked(toModel(state.chain.intrinsics, problem.width, problem.height));
    return "";
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
}

}  // namespace planar_bin_picking
