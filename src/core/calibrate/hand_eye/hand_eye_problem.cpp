// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/hand_eye/hand_eye_problem.h"

#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

void refuse(const std::string& what) { throw std::invalid_argument("hand-eye: " + what); }

/// As many corners as the board has, or a part of a board whose corners are told apart.
void checkCorners(const Board& board, const Observation& observation) {
  const std::size_t count = observation.corners.size();
  if (observation.ids.empty()) {
    if (count == board.size()) return;
    refuse(observation.name + " has " + std::to_string(count) + " corners, the board has " +
           std::to_string(board.size()));
  }
  if (board.kind != Board::Kind::kCharuco) {
    refuse(observation.name + " has ids of corners, which a board without markers cannot give");
  }
  if (observation.ids.size() != count) {
    refuse(observation.name + " has " + std::to_string(count) + " corners and " +
           std::to_string(observation.ids.size()) + " ids");
  }
  std::vector<bool> is_known(board.size(), false);
  for (const std::size_t id : observation.ids) {
    if (id >= board.size() || is_known[id]) {
      refuse(observation.name + " has the id " + std::to_string(id) +
             (id < board.size() ? " twice" : ", the board has corners up to ") +
             (id < board.size() ? "" : std::to_string(board.size() - 1)));
    }
    is_known[id] = true;
  }
  if (!areEnough(board, observation.ids)) {
    refuse(observation.name + " has " + std::to_string(count) + " corners, fewer than " +
           std::to_string(kCornersLeast) + " or nearly in a row");
  }
}

}  // namespace

const char* nameOf(Verdict verdict) {
  return verdict == Verdict::kGood ? "GOOD" : verdict == Verdict::kPoor ? "POOR" : "REFUSED";
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
  for (const Observation& observation : problem.observations) {
    checkCorners(problem.board, observation);
    bool finite = observation.T_base_flange.matrix().allFinite();
    for (const Eigen::Vector2d& p : observation.corners) finite = finite && p.allFinite();
    if (!finite) refuse(observation.name + " has numbers that are not finite");
    const Eigen::Matrix3d R = observation.T_base_flange.linear();
    if ((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() > 1e-4 || R.determinant() < 0.0) {
      refuse(observation.name + ": the robot pose is no rigid motion");
    }
  }
}

void validate(const HandEyeParams& params) {
  HandEyeParams::fields(params, [](const std::string& key, const auto& value, auto min, auto max) {
    if (value >= min && value <= max) return;
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << key << " is " << value << ", must be between " << min << " and " << max;
    throw std::invalid_argument(text.str());
  });
  if ((params.robot_sigma_mm > 0.0) != (params.robot_sigma_deg > 0.0)) {
    throw std::invalid_argument(
        "robot_sigma_mm and robot_sigma_deg: give both, or neither to have them estimated");
  }
}

}  // namespace planar_bin_picking
