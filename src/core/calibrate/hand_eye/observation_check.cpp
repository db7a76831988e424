// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/observation_check.h"

#include "base/scatter.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;

std::vector<Eigen::Vector2d> reordered(const std::vector<Eigen::Vector2d>& corners,
                                       const std::vector<std::size_t>& ordering) {
  std::vector<Eigen::Vector2d> out;
  for (const std::size_t i : ordering) out.push_back(corners[i]);
  return out;
}

double meanShift(const Sighting& a, const Sighting& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.corners.size(); ++i) sum += (a.corners[i] - b.corners[i]).norm();
  return sum / static_cast<double>(a.corners.size());
}

/// Pairs of the same robot pose whose boards stand elsewhere in the image.
void findStale(const std::vector<Usable>& views, Findings* findings) {
  constexpr double kSameMetres = 2e-5, kSameRadians = 0.01 * kRadians, kMovedPx = 3.0;
  for (std::size_t i = 1; i < views.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Sighting &a = views[i].sighting, &b = views[j].sighting;
      const Eigen::Isometry3d between = a.T_base_flange.inverse() * b.T_base_flange;
      if (between.translation().norm() > kSameMetres) continue;
      if (rotationAngle(between.linear()) > kSameRadians) continue;
      if (meanShift(a, b) < kMovedPx) continue;
      findings->stale.push_back(a.name + " and " + b.name);
      break;
    }
  }
}

/// Whether the poses fit if each is taken for the picture before or after its own.
bool lateByOne(const std::vector<Usable>& views, double wrong) {
  std::vector<Motion> motions;
  for (const Usable& view : views) motions.push_back(view.motion);
  if (motions.size() < 5 || median(angleErrors(motions)) < wrong) return false;
  std::vector<Motion> shifted;
  for (std::size_t i = 1; i < motions.size(); ++i) {
    shifted.push_back({motions[i].robot, motions[i - 1].board});
  }
  return median(angleErrors(shifted)) < 0.3 * wrong;
}

void refuse(const std::string& what) { throw std::invalid_argument("hand-eye: " + what); }

}  // namespace

std::vector<Usable> checkSightings(const HandEyeProblem& problem, const HandEyeParams& params,
                                   const std::array<double, 9>& intrinsics,
                                   std::vector<ViewResult>* views, Findings* findings) {
  const Camera::Model camera =
      problem.camera ? *problem.camera : toModel(intrinsics, problem.width, problem.height);
  std::vector<Usable> usable;
  for (std::size_t i = 0; i < problem.sightings.size(); ++i) {
    const Sighting& sighting = problem.sightings[i];
    const auto T_camera_board = boardPose(camera, problem.board, sighting.corners);
    if (T_camera_board) {
      const Eigen::Isometry3d robot = robotSide(problem.mounting, sighting.T_base_flange);
      usable.push_back({i, sighting, {robot, *T_camera_board}});
    } else {
      (*views)[i].why_not = "no pose of the board fits its corners";
    }
  }
  std::vector<Motion> motions;
  for (const Usable& view : usable) motions.push_back(view.motion);
  const auto all = orderings(problem.board);
  const std::vector<std::size_t> chosen = chooseOrderings(motions, problem.board);
  for (std::size_t i = 0; i < usable.size(); ++i) {
    Usable& view = usable[i];
    if (chosen[i] == 0) continue;
    view.sighting.corners = reordered(view.sighting.corners, all[chosen[i]]);
    view.motion.board =
        boardPose(camera, problem.board, view.sighting.corners).value_or(view.motion.board);
    motions[i] = view.motion;
  }
  findStale(usable, findings);
  findings->late_by_one = lateByOne(usable, params.wrong_pair_deg * kRadians);
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

void validate(const HandEyeProblem& problem) {
  validate(problem.board);
  if (problem.width <= 0 || problem.height <= 0) refuse("image size is not set");
  if (problem.camera) {
    if (problem.camera->width != problem.width || problem.camera->height != problem.height) {
      refuse("the given camera is for images of " + std::to_string(problem.camera->width) + " x " +
             std::to_string(problem.camera->height) + ", but these have " +
             std::to_string(problem.width) + " x " + std::to_string(problem.height));
    }
    const Camera checked(*problem.camera);
  }
  for (const Sighting& sighting : problem.sightings) {
    if (sighting.corners.size() != problem.board.size()) {
      refuse(sighting.name + " has " + std::to_string(sighting.corners.size()) +
             " corners, the board has " + std::to_string(problem.board.size()));
    }
    bool finite = sighting.T_base_flange.matrix().allFinite();
    for (const Eigen::Vector2d& p : sighting.corners) finite = finite && p.allFinite();
    if (!finite) refuse(sighting.name + " has numbers that are not finite");
    const Eigen::Matrix3d R = sighting.T_base_flange.linear();
    if ((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() > 1e-4 || R.determinant() < 0.0) {
      refuse(sighting.name + ": the robot pose is no rigid motion");
    }
  }
}

}  // namespace planar_bin_picking
