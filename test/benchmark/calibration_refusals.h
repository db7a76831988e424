// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Calibrations that must be refused: how many are.

#include "calibration_statistics.h"
#include "planar_bin_picking/calibrate/board/checkerboard.h"

#include <cstdio>
#include <functional>
#include <string>

namespace planar_bin_picking {

/// Turns about the board's normal (or the fixed camera's axis) alone.
inline HandEyeProblem oneAxis(const sim::BoardCell& cell, std::mt19937* random) {
  HandEyeProblem problem = emptyProblem(cell);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Eigen::Isometry3d first = cell.flangeFor(sim::randomView(cell, 0.5, 20.0, 0.1, random));
  const Eigen::Vector3d axis =
      first.linear().transpose() *
      (cell.in_hand ? cell.T_other_board.linear().col(2) : cell.T_mount_camera.linear().col(2));
  while (problem.observations.size() < 12) {
    Eigen::Isometry3d T = first;
    T.linear() = first.linear() * Eigen::AngleAxisd(0.4 * any(*random), axis).toRotationMatrix();
    T.translation() += 0.02 * Eigen::Vector3d(any(*random), any(*random), any(*random));
    addObservation(cell, T, random, &problem);
  }
  return problem;
}

inline HandEyeProblem withSquare(HandEyeProblem problem, double factor) {
  problem.board.square *= factor;
  return problem;
}

/// Poses `late` pictures old, or all of the later ones frozen.
inline HandEyeProblem stale(HandEyeProblem problem, std::size_t late, std::size_t frozen_from) {
  const HandEyeProblem right = problem;
  for (std::size_t i = late; i < right.observations.size(); ++i) {
    problem.observations[i].T_base_flange =
        right.observations[std::min(i - late, frozen_from)].T_base_flange;
  }
  return problem;
}

/// Pictures of the board, searched for one of `cols` x `rows`.
inline HandEyeProblem counted(sim::BoardCell cell, int cols, int rows, std::mt19937* random) {
  cell.camera = {800, 640, 1100.0, 1098.5, 404.0, 316.0, {-0.1, 0.06, -5e-4, 4e-4, 0.0}};
  HandEyeProblem problem = emptyProblem(cell);
  problem.board.cols = cols;
  problem.board.rows = rows;
  std::vector<Eigen::Vector2d> corners;
  for (int i = 0; i < 12;) {
    const auto T_camera_board = sim::randomView(cell, 0.42, 35.0, 0.5, random);
    if (!sim::seeCorners(cell, T_camera_board, random, &corners)) continue;
    const cv::Mat image = sim::takeBoardImage(cell, T_camera_board, 0.7, 2.0, ++i);
    const BoardObservation observation = findBoard(image, problem.board, 4.0);
    if (observation.status != BoardObservation::Status::kFound) continue;
    problem.observations.push_back(
        {"view " + std::to_string(i), cell.flangeFor(T_camera_board), observation.corners});
  }
  return problem;
}

inline void printRefusals(int seeds) {
  using Cell = sim::BoardCell;
  struct Case {
    const char* name;
    int seeds;
    std::function<HandEyeProblem(Cell, std::mt19937*)> make;
  };
  const int drawn = std::max(1, seeds / 10);  // pictures take their time
  const auto good = [](const Cell& cell, std::mt19937* random) {
    return randomProblem(cell, 14, random);
  };
  const std::vector<Case> cases = {
      {"rotations about one axis", seeds, oneAxis},
      {"5 views", seeds, [](Cell c, auto* r) { return randomProblem(c, 5, r); }},
      {"square stated 5 % too large", seeds,
       [&](Cell c, auto* r) { return withSquare(good(c, r), 1.05); }},
      {"square stated twice as large", seeds,
       [&](Cell c, auto* r) { return withSquare(good(c, r), 2.0); }},
      {"9x6 counted as 8x6", drawn, [](Cell c, auto* r) { return counted(c, 8, 6, r); }},
      {"9x6 counted as 9x5", drawn, [](Cell c, auto* r) { return counted(c, 9, 5, r); }},
      {"9x6 counted as 10x7", drawn, [](Cell c, auto* r) { return counted(c, 10, 7, r); }},
      {"tf one picture late", seeds, [&](Cell c, auto* r) { return stale(good(c, r), 1, 100); }},
      {"tf frozen after 5 pictures", seeds,
       [&](Cell c, auto* r) { return stale(good(c, r), 0, 4); }},
      {"robot noise 10 mm / 0.8 deg", seeds,
       [&](Cell c, auto* r) {
         c.robot_mm = 10.0;
         c.robot_deg = 0.8;
         return good(c, r);
       }},
      {"the other mounting", seeds, [&](Cell c, auto* r) {
         HandEyeProblem problem = good(c, r);
         problem.mounting = c.in_hand ? Mounting::kEyeToHand : Mounting::kEyeInHand;
         return problem;
       }}};
  std::printf(
      "\n| must be refused | refused | of | first reason, of the last |\n|---|---|---|---|\n");
  for (const Case& what : cases) {
    int refused = 0;
    std::string reason;
    for (int seed = 1; seed <= what.seeds; ++seed) {
      std::mt19937 random(static_cast<unsigned>(seed));
      Cell cell = sim::makeCell(seed % 2 == 0, &random);
      cell.robot_mm = 0.1;
      cell.robot_deg = 0.02;
      const HandEyeResult result = solveHandEye(what.make(cell, &random), {});
      refused += result.verdict == Verdict::kRefused ? 1 : 0;
      reason = result.reasons.empty() ? "" : result.reasons[0].substr(0, 60);
    }
    std::printf("| %s | %d | %d | %s |\n", what.name, refused, what.seeds, reason.c_str());
    std::fflush(stdout);
  }
}

}  // namespace planar_bin_picking
