// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The solver against OpenCV's Park on the same corners, and both against what is possible.

#include "calibrate/board/board_views.h"
#include "calibrate/hand_eye/closed_form.h"
#include "calibrate/hand_eye/normal_equations.h"
#include "calibration_statistics.h"

#include <opencv2/calib3d.hpp>

#include <cstdio>

namespace planar_bin_picking {

/// Intrinsics as an OpenCV user has them: cv::calibrateCamera on the same corners.
inline Camera::Model openCvCamera(const HandEyeProblem& problem) {
  std::vector<cv::Point3f> board;
  for (std::size_t i = 0; i < problem.board.size(); ++i) {
    const Eigen::Vector3f x = problem.board.corner(i).cast<float>();
    board.emplace_back(x.x(), x.y(), 0.0F);
  }
  std::vector<std::vector<cv::Point2f>> images;
  for (const Observation& observation : problem.observations) {
    std::vector<cv::Point2f>& points = images.emplace_back();
    for (const Eigen::Vector2d& p : observation.corners) points.emplace_back(p.x(), p.y());
  }
  cv::Mat_<double> K, d;
  std::vector<cv::Mat> r, t;
  cv::calibrateCamera(std::vector<std::vector<cv::Point3f>>(images.size(), board), images,
                      {problem.width, problem.height}, K, d, r, t);
  return {problem.width, problem.height, K(0, 0),     K(1, 1),
          K(0, 2),       K(1, 2),        "plumb_bob", {d.begin(), d.end()}};
}

inline PoseError parkError(const sim::BoardCell& cell, const HandEyeProblem& problem,
                           const Camera::Model& camera) {
  std::vector<PosePair> motions;
  for (const Observation& s : problem.observations) {
    const auto T_camera_board = boardPose(camera, seenPoints(problem.board, s));
    if (T_camera_board) {
      motions.push_back({robotSide(problem.mounting, s.T_base_flange), *T_camera_board});
    }
  }
  // The package's own form comes first, then Park's.
  const auto chains = closedForms(problem, motions, fromModel(camera), {}, false);
  return poseError(chains.at(1).T_mount_camera, cell.T_mount_camera);
}

/// Cramer and Rao's bound: the RMS error of the best unbiased estimate, noise and truth known to
/// it.
inline PoseError bound(const sim::BoardCell& cell, const HandEyeProblem& problem) {
  Chain chain;
  chain.mounting = problem.mounting;
  chain.intrinsics = fromModel(trueCamera(cell));
  chain.T_mount_camera = cell.T_mount_camera;
  chain.T_other_board = cell.T_other_board;
  const Noise noise{cell.corner_px, 1e-3 * cell.robot_mm, sim::kDegree * cell.robot_deg};
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kColumns, kColumns);
  for (const Observation& s : problem.observations) {
    information += viewInformation(chain, noise, s.points(problem.board), s.T_base_flange);
  }
  const auto covariance = invertInformation(information, {});
  if (!covariance) return {};
  return {1e3 * std::sqrt(covariance->block<3, 3>(kHandEye, kHandEye).trace()),
          std::sqrt(covariance->block<3, 3>(kHandEye + 3, kHandEye + 3).trace()) / sim::kDegree};
}

/// Means of squares, of which the roots are printed.
struct Rivals {
  enum Name { kBound, kOwn, kParkOpenCv, kParkTrue, kCount };
  double mm2[kCount] = {}, deg2[kCount] = {};
  int runs = 0;

  void add(Name name, const PoseError& error) {
    mm2[name] += error.mm * error.mm;
    deg2[name] += error.deg * error.deg;
  }
};

/// A board at `distance`, tilted by up to `tilt_deg`.
struct ParkCase {
  const char* name;
  int views;
  double distance, tilt_deg;
  bool far_board;  ///< 3 x 4 corners of 50 mm and a camera of 2 Mpx, as in many cells with a fixed
                   ///< camera
};

inline void addRivals(const ParkCase& what, const Robot& robot, unsigned seed, Rivals* rivals) {
  std::mt19937 random(seed);
  sim::BoardCell cell = sim::makeCell(seed % 2 == 0, &random);
  if (what.far_board) {
    cell.camera = {1920, 1080, 1371.0, 1371.0, 959.5, 539.5, {}};
    cell.cols = 3;
    cell.rows = 4;
    cell.square = 0.05;
  }
  cell.robot_mm = robot.mm;
  cell.robot_deg = robot.deg;
  HandEyeProblem problem = emptyProblem(cell);
  while (static_cast<int>(problem.observations.size()) < what.views) {
    const auto T_camera_board = sim::randomView(cell, what.distance, what.tilt_deg, 0.6, &random);
    addObservation(cell, cell.flangeFor(T_camera_board), &random, &problem);
  }
  const HandEyeResult result = solveHandEye(problem, {});
  if (!result.solved) return;
  ++rivals->runs;
  rivals->add(Rivals::kBound, bound(cell, problem));
  rivals->add(Rivals::kOwn, poseError(result.T_mount_camera, cell.T_mount_camera));
  rivals->add(Rivals::kParkOpenCv, parkError(cell, problem, openCvCamera(problem)));
  rivals->add(Rivals::kParkTrue, parkError(cell, problem, trueCamera(cell)));
}

inline void printPark(int seeds) {
  std::printf(
      "\n| views (random) | robot | solved | bound mm / deg | this package | Park, OpenCV's "
      "intrinsics | Park, true intrinsics | Park / this, mm "
      "|\n|---|---|---|---|---|---|---|---|\n");
  const ParkCase cases[] = {{"8, near", 8, 0.43, 35.0, false},
                            {"15, near", 15, 0.43, 35.0, false},
                            {"30, near", 30, 0.43, 35.0, false},
                            {"15, near, tilt 12 deg", 15, 0.43, 12.0, false},
                            {"20, far board", 20, 1.8, 35.0, true}};
  for (const ParkCase& what : cases) {
    for (const Robot& robot : {kRobots[1], kRobots[2]}) {
      Rivals rivals;
      for (int seed = 1; seed <= seeds; ++seed) {
        addRivals(what, robot, static_cast<unsigned>(seed), &rivals);
      }
      std::printf("| %s | %.1f mm / %.2f deg | %d |", what.name, robot.mm, robot.deg, rivals.runs);
      for (int i = 0; i < Rivals::kCount; ++i) {
        std::printf(" %.3f / %.4f |", std::sqrt(rivals.mm2[i] / rivals.runs),
                    std::sqrt(rivals.deg2[i] / rivals.runs));
      }
      std::printf(" %.2f |\n",
                  std::sqrt(rivals.mm2[Rivals::kParkOpenCv] / rivals.mm2[Rivals::kOwn]));
      std::fflush(stdout);
    }
  }
}

}  // namespace planar_bin_picking
