// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/observation_check.h"

#include "base/scatter.h"
#include "calibrate/board/board_views.h"
#include "calibrate/hand_eye/mistakes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;

/// How far the corners moved that both saw; far, where there is none.
double meanShift(const Observation& a, const Observation& b) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < a.corners.size(); ++i) {
    std::size_t k = i;
    if (!a.ids.empty()) {
      const auto same = std::find(b.ids.begin(), b.ids.end(), a.ids[i]);
      if (same == b.ids.end()) continue;
      k = static_cast<std::size_t>(same - b.ids.begin());
    }
    sum += (a.corners[i] - b.corners[k]).norm();
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::numeric_limits<double>::infinity();
}

/// Pairs of the same robot pose whose boards stand elsewhere in the image.
void findStale(const std::vector<Usable>& views, Findings* findings) {
  constexpr double kSameMetres = 2e-5, kSameRadians = 0.01 * kRadians, kMovedPx = 3.0;
  for (std::size_t i = 1; i < views.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Observation &a = views[i].observation, &b = views[j].observation;
      const Eigen::Isometry3d between = a.T_base_flange.inverse() * b.T_base_flange;
      if (between.translation().norm() > kSameMetres) continue;
      if (rotationAngle(between.linear()) > kSameRadians) continue;
      if (meanShift(a, b) < kMovedPx) continue;
      findings->stale.push_back(a.name + " and " + b.name);
      break;
    }
  }
}

/// Of nearly equal views the first counts; @return those that count.
std::vector<Usable> withoutRepeated(const HandEyeProblem& problem, const std::vector<Usable>& views,
                                    std::vector<ViewResult>* results, Findings* findings) {
  // Views less apart than this tell next to nothing beyond each other.
  constexpr double kSameShare = 0.004, kSameAngle = 0.5 * kRadians;
  // A picture that is the very same while the robot went elsewhere is an old one.
  constexpr double kFrozenPx = 0.5, kWentMetres = 5e-3, kWentRadians = 1.0 * kRadians;
  std::vector<Usable> kept;
  for (const Usable& view : views) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const Usable& other) {
      const double turned =
          rotationAngle(view.poses.board.linear().transpose() * other.poses.board.linear());
      return turned < kSameAngle &&
             meanShift(view.observation, other.observation) < kSameShare * problem.width;
    });
    if (same == kept.end()) {
      kept.push_back(view);
      continue;
    }
    ++findings->repeated;
    (*results)[view.index].why_not = "the same view as " + same->observation.name;
    const Eigen::Isometry3d between =
        view.observation.T_base_flange.inverse() * same->observation.T_base_flange;
    const bool went = between.translation().norm() > kWentMetres ||
                      rotationAngle(between.linear()) > kWentRadians;
    if (went && meanShift(view.observation, same->observation) < kFrozenPx) {
      findings->frozen.push_back(same->observation.name + " and " + view.observation.name);
    }
  }
  return kept;
}

}  // namespace

std::vector<Usable> checkObservations(const HandEyeProblem& problem, const HandEyeParams& params,
                                      const Intrinsics& intrinsics, std::vector<ViewResult>* views,
                                      Findings* findings) {
  const Camera::Model camera =
      problem.camera ? *problem.camera : toModel(intrinsics, problem.width, problem.height);
  std::vector<Usable> usable;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const Observation& observation = problem.observations[i];
    const auto T_camera_board = boardPose(camera, seenPoints(problem.board, observation));
    if (T_camera_board) {
      const Eigen::Isometry3d robot = robotSide(problem.mounting, observation.T_base_flange);
      usable.push_back({i, observation, {robot, *T_camera_board}});
    } else {
      (*views)[i].why_not = "no pose of the board fits its corners";
    }
  }
  std::vector<PosePair> motions;
  for (const Usable& view : usable) motions.push_back(view.poses);
  const auto all = orderings(problem.board);
  const std::vector<std::size_t> chosen = chooseOrderings(motions, problem.board);
  for (std::size_t i = 0; i < usable.size(); ++i) {
    Usable& view = usable[i];
    if (chosen[i] == 0) continue;
    view.observation.corners = reordered(view.observation.corners, all[chosen[i]]);
    view.poses.board =
        boardPose(camera, seenPoints(problem.board, view.observation)).value_or(view.poses.board);
    motions[i] = view.poses;
  }
  findStale(usable, findings);
  usable = withoutRepeated(problem, usable, views, findings);
  motions.clear();
  std::vector<Observation> observations;
  for (const Usable& view : usable) {
    motions.push_back(view.poses);
    observations.push_back(view.observation);
  }
  findings->late_by_one = areLateByOne(problem, intrinsics, params, observations, motions);
  const std::vector<double> errors = angleErrors(motions);
  std::vector<Usable> good;
  for (std::size_t i = 0; i < usable.size(); ++i) {
    if (errors[i] <= params.wrong_pair_deg * kRadians) {
      good.push_back(usable[i]);
      continue;
    }
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(3);
    text << "robot and board turn by angles that differ by " << errors[i] / kRadians << " deg";
    (*views)[usable[i].index].why_not = text.str();
  }
  return good;
}

}  // namespace planar_bin_picking
