// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The simulated cell's observations as the solver takes them.

#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"
#include "sim/markers.h"

namespace planar_bin_picking {

inline Board boardOf(const sim::BoardCell& cell) {
  Board board{cell.cols, cell.rows, cell.square};
  if (cell.markers.empty()) return board;
  board.kind = Board::Kind::kCharuco;
  board.marker = cell.marker;
  board.dictionary = sim::kDictionary;
  return board;
}

inline HandEyeProblem emptyProblem(const sim::BoardCell& cell) {
  HandEyeProblem problem;
  problem.mounting = cell.in_hand ? Mounting::kEyeInHand : Mounting::kEyeToHand;
  problem.board = boardOf(cell);
  problem.width = cell.camera.width;
  problem.height = cell.camera.height;
  return problem;
}

/// One observation from where the robot stands; false where the board is not all in the image.
inline bool addObservation(const sim::BoardCell& cell, const Eigen::Isometry3d& T_base_flange,
                           std::mt19937* random, HandEyeProblem* problem) {
  Observation observation;
  if (!sim::seeCorners(cell, cell.cameraBoard(T_base_flange), random, &observation.corners))
    return false;
  observation.name = "view " + std::to_string(problem->observations.size() + 1);
  observation.T_base_flange = sim::reported(cell, T_base_flange, random);
  problem->observations.push_back(observation);
  return true;
}

/// `count` random views; the distance lets the board fill a good half of the image.
inline HandEyeProblem randomProblem(const sim::BoardCell& cell, int count, std::mt19937* random,
                                    double tilt_deg = 35.0) {
  HandEyeProblem problem = emptyProblem(cell);
  const double distance = 1.7 * cell.square * cell.cols * cell.camera.fx / cell.camera.width;
  while (static_cast<int>(problem.observations.size()) < count) {
    const auto T_camera_board = sim::randomView(cell, distance, tilt_deg, 0.6, random);
    addObservation(cell, cell.flangeFor(T_camera_board), random, &problem);
  }
  return problem;
}

}  // namespace planar_bin_picking
