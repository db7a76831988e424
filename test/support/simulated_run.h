// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A whole calibration in the simulated cell: corners instead of pictures, a robot that may refuse.

#include "planar_bin_picking/calibrate/calibration_run.h"
#include "support/board_problem.h"

namespace planar_bin_picking {

/// A hall with room for everything.
inline RunParams wideRun() {
  RunParams params;
  MotionParams& motion = params.motion;
  motion.workspace_min_x = motion.workspace_min_y = motion.workspace_min_z = -2.0;
  motion.workspace_max_x = motion.workspace_max_y = motion.workspace_max_z = 2.0;
  return params;
}

struct RunOutcome {
  HandEyeResult result;
  std::vector<Eigen::Isometry3d> asked;     ///< for pictures
  std::vector<Eigen::Isometry3d> commands;  ///< all, in order, the way back too
  std::vector<Eigen::Isometry3d> stood;     ///< where the robot said it stood before each of them
  CalibrationRun::End end = CalibrationRun::End::kNone;
  std::string failure;  ///< what the run threw
  HandEyeProblem problem;
  int pictures = 0, refused = 0, lost = 0;
  int beyond = 0;  ///< targets nearer to the limits than a target may be
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
    T_base_said = T_base_start;
    try {
      while (const auto target = run.next()) {
        outcome.asked.push_back(*target);
        const bool is_start = outcome.asked.size() == 1;
        if (!is_start && !run.limits().allowsTarget(*target)) ++outcome.beyond;
        visit(*target, &run, &outcome);
      }
      if (run.headBack()) drive(&run, &outcome);
    } catch (const std::runtime_error& error) {
      outcome.failure = error.what();
    }
    outcome.end = run.end();
    outcome.problem = run.problem();
    if (solves) outcome.result = run.result();
    return outcome;
  }

  /// A cell and a robot as narrow and as bad as they come; changes what goes wrong in this world.
  RunParams randomParams() {
    std::uniform_real_distribution<double> any(0.0, 1.0);
    const auto between = [&](double low, double high) { return low + (high - low) * any(random); };
    RunParams params;
    MotionParams& motion = params.motion;
    const Eigen::Vector3d p = T_base_start.translation();
    motion.workspace_min_x = p.x() - between(0.31, 1.0);
    motion.workspace_min_y = p.y() - between(0.31, 1.0);
    motion.workspace_min_z = p.z() - between(0.31, 1.0);
    motion.workspace_max_x = p.x() + between(0.31, 1.0);
    motion.workspace_max_y = p.y() + between(0.31, 1.0);
    motion.workspace_max_z = p.z() + between(0.31, 1.0);
    if (any(random) < 0.5) {
      const Eigen::Vector3d n = Eigen::Vector3d(between(-1, 1), between(-1, 1), 1.0).normalized();
      motion.planes = {n.x(), n.y(), n.z(), n.dot(p) - between(0.31, 0.6)};
    }
    motion.cone_deg = between(10.0, 100.0);
    motion.max_roll_deg = between(10.0, 180.0);
    motion.max_step_m = between(0.01, 0.3);
    motion.max_turn_deg = between(2.0, 90.0);
    motion.clearance_m = between(0.0, 0.1);
    params.first_turn_deg = between(4.0, 20.0);
    params.views_max = 5 + static_cast<int>(between(1.0, 4.0));
    params.attempts_max = 20;
    params.candidates = 10;
    cell.robot_mm = between(0.0, 1.0);
    cell.robot_deg = between(0.0, 0.1);
    unreachable = any(random) < 0.3 ? 0.2 : 0.0;
    failing = any(random) < 0.3 ? 0.05 : 0.0;
    blind = any(random) < 0.3 ? 0.2 : 0.0;
    astray = any(random) < 0.2 ? 0.05 : 0.0;
    solves = false;
    return params;
  }

  /// Of a robot with six axes, or with four.
  HandEyeParams randomSolver() {
    std::uniform_real_distribution<double> any(0.0, 1.0);
    HandEyeParams solver;
    solver.four_axis = any(random) < 0.2;
    if (solver.four_axis) solver.board_z = (cell.T_other_board * cell.centre()).z();
    return solver;
  }

  /// @return  the pose that the robot refuses
  std::optional<Eigen::Isometry3d> drive(CalibrationRun* run, RunOutcome* outcome) {
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    while (const auto command = run->step()) {
      if (isUnreachable(*command) || chance(random) < failing) return command;
      outcome->stood.push_back(T_base_said);
      outcome->commands.push_back(*command);
      // A robot that goes elsewhere ends the run, unless that is within reached_mm.
      if (chance(random) < astray) throw std::runtime_error("the robot is not where it was sent");
      T_base_said = sim::reported(cell, *command, &random);
      run->arrived(T_base_said);
    }
    if (!run->isThere()) return run->way().back();
    return std::nullopt;
  }

  void visit(const Eigen::Isometry3d& target, CalibrationRun* run, RunOutcome* outcome) {
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    if (const auto refused = drive(run, outcome)) {
      ++outcome->refused;
      run->refused(*refused);
      return;
    }
    HandEyeProblem one = emptyProblem(cell);
    if (chance(random) >= blind && addObservation(cell, target, &random, &one)) {
      one.observations[0].name = "view " + std::to_string(++outcome->pictures);
      run->seen(one.observations[0]);
    } else {
      ++outcome->lost;
      run->lost();
    }
  }

  std::mt19937 random;
  sim::BoardCell cell;
  Eigen::Isometry3d T_base_start = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_base_said = Eigen::Isometry3d::Identity();
  double unreachable = 0.0, failing = 0.0, blind = 0.0, astray = 0.0;  // shares
  bool solves = true;                                                  // at the end
};

}  // namespace planar_bin_picking
