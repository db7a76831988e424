// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A whole calibration in the simulated cell: corners instead of pictures, a robot that may refuse.

#include "planar_bin_picking/calibrate/calibration_run.h"
#include "support/board_problem.h"

namespace planar_bin_picking {

struct RunOutcome {
  HandEyeResult result;
  std::vector<Eigen::Isometry3d> asked;
  HandEyeProblem problem;
  int pictures = 0, refused = 0, lost = 0;
};

/// A camera anywhere within 0.3 m of its mount, at any turn about its axis; the board is seen at
/// the start.
struct RunWorld {
  RunWorld(bool in_hand, unsigned seed, const sim::PinholeCamera& camera = sim::BoardCell().camera)
      : random(seed) {
    cell = sim::makeCell(in_hand, &random);
    cell.camera = camera;
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    if (in_hand) {
      Eigen::Vector3d at;
      do {
        at = {0.3 * any(random), 0.3 * any(random), 0.3 * any(random)};
      } while (at.norm() > 0.3);
      cell.T_mount_camera.translation() = at;
    }
    std::vector<Eigen::Vector2d> corners;
    do {
      const auto T_camera_board = sim::randomView(cell, 0.45, 20.0, 0.3, &random);
      T_base_start = cell.flangeFor(T_camera_board);
    } while (!sim::seeCorners(cell, cell.cameraBoard(T_base_start), &random, &corners));
  }

  /// Whether the robot cannot get there: a fixed property of a place, as with a real one.
  bool isUnreachable(const Eigen::Isometry3d& T) const {
    if (T.isApprox(T_base_start)) return false;  // it stands there
    double code = 0.0;
    for (int i = 0; i < 3; ++i) code += std::floor(T.translation()[i] / 0.02) * (17.31 + 5.77 * i);
    code += std::floor(T.linear()(0, 0) / 0.1) * 3.37;
    return std::abs(std::fmod(std::abs(std::sin(code) * 43758.5453), 1.0)) < unreachable;
  }

  RunOutcome run(const RunParams& params, const HandEyeParams& solver = {}) {
    CalibrationRun run(emptyProblem(cell), solver, params, T_base_start);
    RunOutcome outcome;
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    while (const auto target = run.next()) {
      outcome.asked.push_back(*target);
      if (isUnreachable(*target) || chance(random) < failing) {
        ++outcome.refused;
        run.refused();
        continue;
      }
      HandEyeProblem one = emptyProblem(cell);
      if (addObservation(cell, *target, &random, &one)) {
        one.observations[0].name = "view " + std::to_string(++outcome.pictures);
        run.seen(one.observations[0]);
      } else {
        ++outcome.lost;
        run.lost();
      }
    }
    outcome.result = run.result();
    outcome.problem = run.problem();
    return outcome;
  }

  std::mt19937 random;
  sim::BoardCell cell;
  Eigen::Isometry3d T_base_start = Eigen::Isometry3d::Identity();
  double unreachable = 0.0, failing = 0.0;  // shares
};

}  // namespace planar_bin_picking
