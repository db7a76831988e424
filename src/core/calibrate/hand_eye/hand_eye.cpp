// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

#include "calibrate/board/board_views.h"
#include "calibrate/hand_eye/closed_form.h"
#include "calibrate/hand_eye/held_out.h"
#include "calibrate/hand_eye/mistakes.h"
#include "calibrate/hand_eye/observation_check.h"
#include "calibrate/hand_eye/verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
/// Fewer views than this determine nothing.
constexpr std::size_t kFewest = 3;

/// One solve under way: the views that count, and what is known so far.
struct Work {
  const HandEyeProblem& problem;
  const HandEyeParams& params;
  std::vector<Usable> usable;
  AdjustOptions options;
  Noise noise;

  std::vector<const Observation*> views() const {
    std::vector<const Observation*> out;
    for (const Usable& view : usable) out.push_back(&view.observation);
    return out;
  }
  std::vector<PosePair> motions() const {
    std::vector<PosePair> out;
    for (const Usable& view : usable) out.push_back(view.poses);
    return out;
  }
};

/// Median over the views of the whole chain's residual.
double chainError(const Work& work, const Chain& chain) {
  std::vector<double> errors;
  for (const Usable& view : work.usable) {
    const auto r = residuals(chain, work.problem.board, view.observation, Vector6d::Zero());
    errors.push_back(r.empty() ? std::numeric_limits<double>::infinity() : rms(r));
  }
  std::sort(errors.begin(), errors.end());
  return errors[errors.size() / 2];
}

std::optional<Chain> bestStart(const Work& work, const Intrinsics& intrinsics, bool free_scale) {
  std::optional<Chain> best;
  double best_error = std::numeric_limits<double>::infinity();
  for (const Chain& chain :
       closedForms(work.problem, work.motions(), intrinsics, work.params, free_scale)) {
    const double error = chainError(work, chain);
    if (!(error < best_error)) continue;
    best = chain;
    best_error = error;
  }
  return best;
}

std::optional<Adjusted> solveFrom(const Work& work, const Intrinsics& intrinsics, bool free_scale) {
  const auto start = bestStart(work, intrinsics, free_scale);
  if (!start) return std::nullopt;
  AdjustOptions options = work.options;
  options.free_scale = free_scale;
  Adjusted state =
      adjust(work.problem, work.views(), startAt(*start, work.noise, work.views()), options);
  if (!state.converged || state.degenerate) return std::nullopt;
  return state;
}

/// Views whose correction is far beyond those of the others: taken while the robot moved, or tf was
/// wrong.
bool dropOutliers(const Adjusted& state, Work* work, std::vector<ViewResult>* views) {
  std::vector<double> t, r;
  for (const Vector6d& c : state.corrections) {
    t.push_back(c.head<3>().norm());
    r.push_back(c.tail<3>().norm());
  }
  const auto middle = [](std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
  };
  // The median of three normal coordinates' norm is 1.54 sigma; 6 sigma never happens by chance.
  const double limit_t = std::max(2e-4, 6.0 / 1.54 * middle(t));
  const double limit_r = std::max(2e-4, 6.0 / 1.54 * middle(r));
  std::vector<Usable> kept;
  for (std::size_t i = 0; i < work->usable.size(); ++i) {
    if (t[i] <= limit_t && r[i] <= limit_r) {
      kept.push_back(work->usable[i]);
      continue;
    }
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(3);
    text << "robot pose is off by " << 1e3 * t[i] << " mm and " << r[i] / kRadians
         << " deg, far more than in the other views";
    (*views)[work->usable[i].index].why_not = text.str();
  }
  const bool dropped = kept.size() < work->usable.size() && kept.size() >= kFewest;
  if (dropped) work->usable = kept;
  return dropped;
}

void fillViews(const Work& work, const Adjusted& state, HandEyeResult* result) {
  double with = 0.0, without = 0.0, floor = 0.0;
  for (std::size_t i = 0; i < work.usable.size(); ++i) {
    const Observation& observation = work.usable[i].observation;
    ViewResult& view = result->views[work.usable[i].index];
    view.used = true;
    view.correction = state.corrections[i];
    view.T_camera_board =
        state.chain.cameraBoard(observation.T_base_flange * exp(state.corrections[i]));
    view.residuals = residuals(state.chain, work.problem.board, observation, state.corrections[i]);
    view.rms_px = rms(view.residuals);
    view.rms_mm = 1e3 * view.rms_px * view.T_camera_board.translation().z() / result->camera.fx;
    Chain placed = state.chain;
    placed.mounting = Mounting::kEyeToHand;
    placed.T_mount_camera = Eigen::Isometry3d::Identity();
    placed.T_other_board = boardPoseNear(
        result->camera, seenPoints(work.problem.board, observation), view.T_camera_board);
    Observation still = observation;
    still.T_base_flange = Eigen::Isometry3d::Identity();
    const auto free = residuals(placed, work.problem.board, still, Vector6d::Zero());
    view.floor_px = free.empty() ? view.rms_px : rms(free);
    const auto raw = residuals(state.chain, work.problem.board, observation, Vector6d::Zero());
    with += view.rms_px * view.rms_px;
    floor += view.floor_px * view.floor_px;
    without += raw.empty() ? 0.0 : std::pow(rms(raw), 2);
  }
  const auto n = static_cast<double>(work.usable.size());
  result->rms_px = std::sqrt(with / n);
  result->chain_px = std::sqrt(without / n);
  result->pnp_floor_px = std::sqrt(floor / n);
}

/// What a robot adds that does not go where it says.
void addRobot(HandEyeResult* result) {
  // Of the pose that is gone to, at the flange; and of the one from which a camera on the flange
  // looked, whose turn moves the part about the flange.
  const bool looks = result->transform_name == "T_flange_camera";
  const double reach =
      (result->T_mount_camera * Eigen::Vector3d(0.0, 0.0, result->working_distance)).norm();
  const double places = 3.0 * std::pow(result->robot_mm, 2);
  const double turns = 3.0 * std::pow(result->robot_deg, 2);
  const double swing = 2.0 * std::pow(1e3 * reach * result->robot_deg * kRadians, 2);
  result->with_robot_mm =
      std::sqrt(std::pow(result->expected_error_mm, 2) + places + (looks ? places + swing : 0.0));
  result->with_robot_deg =
      std::sqrt(std::pow(result->expected_error_deg, 2) + (looks ? 2.0 : 1.0) * turns);
}

void fillSolution(const Work& work, const Adjusted& state, HandEyeResult* result) {
  result->solved = true;
  result->T_mount_camera = state.chain.T_mount_camera;
  result->T_other_board = state.chain.T_other_board;
  result->camera = work.problem.camera
                       ? *work.problem.camera
                       : toModel(state.chain.intrinsics, work.problem.width, work.problem.height);
  result->covariance = state.covariance.topLeftCorner<kSharedSize, kSharedSize>();
  result->sigma_px = state.noise.pixel;
  result->robot_mm = 1e3 * state.noise.robot_t;
  result->robot_deg = state.noise.robot_r / kRadians;
  fillViews(work, state, result);
  if (state.camera_model_error > 0.0) {
    double corners = 0.0;
    for (const Usable& view : work.usable) {
      corners += static_cast<double>(view.observation.corners.size());
    }
    const double without =
        std::pow(result->rms_px, 2) -
        state.camera_model_error * std::pow(state.noise.effectivePixel(), 2) / corners;
    result->own_camera_px = std::sqrt(std::max(0.0, without));
  }
  std::vector<double> distances;
  for (const ViewResult& view : result->views) {
    if (view.used) distances.push_back(view.T_camera_board.translation().norm());
  }
  std::sort(distances.begin(), distances.end());
  result->working_distance = work.params.working_distance > 0.0 ? work.params.working_distance
                                                                : distances[distances.size() / 2];
  const ErrorModel model(state.chain, work.problem.width, work.problem.height,
                         result->working_distance);
  const ExpectedError error = model.of(state.covariance);
  result->expected_error_mm = 1e3 * error.metres;
  result->expected_error_deg = error.radians / kRadians;
  addRobot(result);
}

/// The board's size, set free, against the robot's moves.
void checkScale(const Work& work, const Intrinsics& intrinsics, HandEyeResult* result) {
  const auto state = solveFrom(work, intrinsics, true);
  if (!state) return;
  result->square_ratio = state->chain.scale;
  result->square_ratio_sigma = state->chain.scale * std::sqrt(state->covariance(kScale, kScale));
}

void leaveOneOut(const Work& work, const Adjusted& state, HandEyeResult* result) {
  AdjustOptions options = work.options;
  options.rounds = 0;
  for (std::size_t leave = 0; leave < work.usable.size(); ++leave) {
    std::vector<const Observation*> views = work.views();
    Adjusted start = state;
    const auto at = static_cast<std::ptrdiff_t>(leave);
    views.erase(views.begin() + at);
    start.corrections.erase(start.corrections.begin() + at);
    start.weights.erase(start.weights.begin() + at);
    const Adjusted without = adjust(work.problem, views, start, options);
    if (!without.converged) continue;
    const Eigen::Isometry3d between =
        state.chain.T_mount_camera.inverse() * without.chain.T_mount_camera;
    const double mm = 1e3 * between.translation().norm();
    if (mm > result->leave_one_out_mm) {
      result->leave_one_out_mm = mm;
      result->leave_one_out_view = work.usable[leave].observation.name;
    }
    result->leave_one_out_deg =
        std::max(result->leave_one_out_deg, rotationAngle(between.linear()) / kRadians);
  }
}

std::optional<Adjusted> solveRobustly(Work* work, const Intrinsics& intrinsics,
                                      std::vector<ViewResult>* views) {
  auto state = solveFrom(*work, intrinsics, false);
  if (state && dropOutliers(*state, work, views)) state = solveFrom(*work, intrinsics, false);
  return state;
}

/// The steps of a solve, each of which may be the last.
void solve(Work* work, const Intrinsics& intrinsics, Findings* findings, HandEyeResult* result) {
  auto state = solveRobustly(work, intrinsics, &result->views);
  // Views that stay near the image's middle leave the lens beyond them open: a plainer one, then.
  for (const LensFreedom plainer :
       {LensFreedom::kStiff, LensFreedom::kFirstRadial, LensFreedom::kNone}) {
    if (!state || lensError(work->problem, *state).empty()) break;
    work->options.lens = plainer;
    state = solveRobustly(work, intrinsics, &result->views);
  }
  result->views_used = static_cast<int>(work->usable.size());
  // With too few views it is refused anyway.
  const bool enough = result->views_used >= work->params.min_views;
  if (enough) checkScale(*work, intrinsics, result);
  if (!state) return;
  findings->camera_error = lensError(work->problem, *state);
  if (!findings->camera_error.empty()) return;
  if (enough) {
    const HeldOut held_out{work->problem, work->views(), &work->options, &*state};
    if (!work->options.fixed_camera) result->lens_trials = chooseLens(held_out);
    result->held_out_px = chooseRobotNoise(held_out);
  }
  fillSolution(*work, *state, result);
  if (enough) leaveOneOut(*work, *state, result);
}

/// The camera as given, or a first one from the corners.
Intrinsics firstCamera(const HandEyeProblem& problem) {
  if (problem.camera) return fromModel(*problem.camera);
  std::vector<SeenPoints> views;
  for (const Observation& observation : problem.observations) {
    views.push_back(seenPoints(problem.board, observation));
  }
  return fromModel(cameraFromBoards(views, problem.width, problem.height));
}

Noise firstNoise(const HandEyeParams& params) {
  Noise noise;
  if (params.robot_sigma_mm > 0.0) noise.robot_t = 1e-3 * params.robot_sigma_mm;
  if (params.robot_sigma_deg > 0.0) noise.robot_r = kRadians * params.robot_sigma_deg;
  return noise;
}

}  // namespace

HandEyeResult solveHandEye(const HandEyeProblem& problem, const HandEyeParams& params) {
  validate(problem);
  validate(params);
  HandEyeResult result;
  const bool in_hand = problem.mounting == Mounting::kEyeInHand;
  result.transform_name = in_hand ? "T_flange_camera" : "T_base_camera";
  result.views.resize(problem.observations.size());
  result.params = params;
  Findings findings;
  if (problem.observations.size() >= kFewest) {
    const Intrinsics intrinsics = firstCamera(problem);
    Work work{problem, params, {}, {}, firstNoise(params)};
    work.options.fixed_camera = problem.camera.has_value();
    work.options.fixed_robot_noise = params.robot_sigma_mm > 0.0 && params.robot_sigma_deg > 0.0;
    if (params.four_axis) {
      const Eigen::Vector3d middle = 0.5 * problem.board.corner(problem.board.size() - 1);
      work.options.height = KnownHeight{middle, params.board_z, 1e-3 * params.board_z_sigma_mm};
    }
    work.usable = checkObservations(problem, params, intrinsics, &result.views, &findings);
    result.views_used = static_cast<int>(work.usable.size());
    result.axes_deg = secondAxis(work.motions(), params) / kRadians;
    if (work.usable.size() >= kFewest) {
      findings.turns = nameTurnFault(problem.observations, result.axes_deg, params);
    }
    if (work.usable.size() >= kFewest) solve(&work, intrinsics, &findings, &result);
    judge(problem, params, findings, &result);
    const bool is_named = findings.late_by_one || !findings.turns.empty() ||
                          !findings.stale.empty() || !findings.frozen.empty();
    if (result.verdict == Verdict::kRefused && !is_named) {
      findings.mistake = nameMistake(problem, intrinsics, params);
    }
  }
  judge(problem, params, findings, &result);
  return result;
}

}  // namespace planar_bin_picking
