// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Calibrations that must be refused: how many are.

#include "calibration_statistics.h"
#include "planar_bin_picking/calibrate/board/find_board.h"
#include "planar_bin_picking/calibrate/board/missing_board.h"

#include <algorithm>
#include <cmath>
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

/// Orientations written in another way than they are read.
enum class Orientation { kRealPartFirst, kAnglesAsVector, kVectorAsAngles };

inline Eigen::Matrix3d misread(const Eigen::Matrix3d& R, Orientation how) {
  if (how == Orientation::kRealPartFirst) {
    const Eigen::Quaterniond q(R);  // written w x y z, read x y z w
    return Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();
  }
  const auto turn = [](const Eigen::Vector3d& w) {
    return Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  };
  const auto roll_pitch_yaw = [](const Eigen::Vector3d& a) {
    return (Eigen::AngleAxisd(a.z(), Eigen::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(a.y(), Eigen::Vector3d::UnitY()) *
            Eigen::AngleAxisd(a.x(), Eigen::Vector3d::UnitX()))
        .toRotationMatrix();
  };
  if (how == Orientation::kVectorAsAngles) return roll_pitch_yaw(rotationVector(R));
  return turn({std::atan2(R(2, 1), R(2, 2)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
               std::atan2(R(1, 0), R(0, 0))});
}

inline HandEyeProblem withPoses(
    HandEyeProblem problem,
    const std::function<Eigen::Isometry3d(const Eigen::Isometry3d&)>& change) {
  for (Observation& o : problem.observations) o.T_base_flange = change(o.T_base_flange);
  return problem;
}

inline HandEyeProblem withOrientations(const HandEyeProblem& problem, Orientation how) {
  return withPoses(problem, [how](const Eigen::Isometry3d& T) {
    return rigid(misread(T.linear(), how), T.translation());
  });
}

/// The first flange pose of a problem nudged and turned: by up to `turn_deg` about all axes, or
/// about the base's upright alone.
inline HandEyeProblem nudged(const sim::BoardCell& cell, double turn_deg, bool upright_alone,
                             std::mt19937* random) {
  HandEyeProblem problem = emptyProblem(cell);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  // Looked at straight: there is room for turns then.
  const Eigen::Isometry3d first = cell.flangeFor(sim::randomView(cell, 0.5, 10.0, 0.1, random));
  while (problem.observations.size() < 12) {
    Eigen::Isometry3d T = first;
    Eigen::Vector3d w(any(*random), any(*random), any(*random));
    if (upright_alone) w.head<2>().setZero();
    w *= turn_deg * sim::kDegree;
    if (w.norm() < 1e-6) continue;
    T.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix() * T.linear();
    T.translation() += 0.03 * Eigen::Vector3d(any(*random), any(*random), any(*random));
    addObservation(cell, T, random, &problem);
  }
  return problem;
}

/// `count` views, each of them `times` times, as a robot that goes the same round again gives them.
inline HandEyeProblem repeated(const sim::BoardCell& cell, int count, int times,
                               std::mt19937* random) {
  const HandEyeProblem once = randomProblem(cell, count, random);
  HandEyeProblem problem = once;
  std::normal_distribution<double> normal(0.0, cell.corner_px);
  for (int i = 1; i < times; ++i) {
    for (Observation o : once.observations) {
      for (Eigen::Vector2d& p : o.corners) p += Eigen::Vector2d(normal(*random), normal(*random));
      problem.observations.push_back(o);
    }
  }
  return problem;
}

/// A mistake, and a word by which its name is known.
struct Mistake {
  const char* name;
  const char* word;
  std::function<HandEyeProblem(const sim::BoardCell&, std::mt19937*)> make;
};

inline std::vector<Mistake> mistakes() {
  using Cell = sim::BoardCell;
  using Random = std::mt19937;
  const auto good = [](const Cell& cell, Random* random) {
    return randomProblem(cell, 14, random);
  };
  return {
      {"millimetres for metres", "millimetres for metres",
       [=](const Cell& c, Random* r) {
         return withPoses(good(c, r), [](Eigen::Isometry3d T) {
           T.translation() *= 1000.0;
           return T;
         });
       }},
      {"poses inverted", "robot poses inverted",
       [=](const Cell& c, Random* r) {
         return withPoses(good(c, r), [](const Eigen::Isometry3d& T) { return T.inverse(); });
       }},
      {"the other mounting", "other mounting",
       [=](const Cell& c, Random* r) {
         HandEyeProblem problem = good(c, r);
         problem.mounting = c.in_hand ? Mounting::kEyeToHand : Mounting::kEyeInHand;
         return problem;
       }},
      {"quaternions w first", "quaternion order",
       [=](const Cell& c, Random* r) {
         return withOrientations(good(c, r), Orientation::kRealPartFirst);
       }},
      {"Euler angles read as a rotation vector", "Euler angles taken for a rotation vector",
       [=](const Cell& c, Random* r) {
         return withOrientations(good(c, r), Orientation::kAnglesAsVector);
       }},
      {"a rotation vector read as Euler angles", "rotation vector taken for Euler angles",
       [=](const Cell& c, Random* r) {
         return withOrientations(good(c, r), Orientation::kVectorAsAngles);
       }},
      {"tf one picture late", "tf is stale",
       [=](const Cell& c, Random* r) { return stale(good(c, r), 1, 100); }},
      {"tf frozen after 5 pictures", "tf is stale",
       [=](const Cell& c, Random* r) { return stale(good(c, r), 0, 4); }},
      {"a robot that does not move", "the robot does not move",
       [](const Cell& c, Random* r) { return repeated(c, 1, 12, r); }},
      {"5 views, three times each", "5 can be used of 15",
       [](const Cell& c, Random* r) { return repeated(c, 5, 3, r); }},
      {"workspace too tight, turns of 4 deg", "views too much alike",
       [](const Cell& c, Random* r) { return nudged(c, 4.0, false, r); }},
      {"4-axis robot", "4-axis robot",
       [](const Cell& c, Random* r) { return nudged(c, 60.0, true, r); }},
  };
}

inline void printMistakes(int seeds) {
  std::printf("\n| mistake | not accepted | named | of |\n|---|---|---|---|\n");
  for (const Mistake& mistake : mistakes()) {
    int refused = 0, named = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      std::mt19937 random(static_cast<unsigned>(seed));
      sim::BoardCell cell = sim::makeCell(seed % 2 == 0, &random);
      cell.robot_mm = 0.1;
      cell.robot_deg = 0.02;
      const HandEyeResult result = solveHandEye(mistake.make(cell, &random), {});
      refused += result.verdict == Verdict::kRefused ? 1 : 0;
      const bool is_named =
          !result.reasons.empty() && result.reasons[0].find(mistake.word) != std::string::npos;
      named += is_named ? 1 : 0;
    }
    std::printf("| %s | %d | %d | %d |\n", mistake.name, refused, named, seeds);
    std::fflush(stdout);
  }
}

/// Pictures of a board that is half out of view, or of none.
inline void printMissingBoards(int seeds) {
  for (const bool none : {false, true}) {
    int named = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      std::mt19937 random(static_cast<unsigned>(seed));
      sim::BoardCell cell = sim::makeCell(true, &random);
      cell.camera = {800, 640, 1100.0, 1098.5, 404.0, 316.0, {-0.1, 0.06, -5e-4, 4e-4, 0.0}};
      std::vector<cv::Mat> images;
      for (int i = 0; i < 3; ++i) {
        Eigen::Isometry3d T = sim::randomView(cell, 0.42, 25.0, 0.0, &random);
        // The board's middle onto the picture's border, or far beyond it.
        const double to_border = 0.5 * cell.camera.width / cell.camera.fx * T.translation().z();
        T.translation().x() += (none ? 4.0 : 1.0) * to_border;
        images.push_back(sim::takeBoardImage(cell, T, 0.7, 2.0, 10 * seed + i));
      }
      const std::string why = whyBoardIsMissing(images, {9, 6, 0.02});
      named += why.find(none ? "no board" : "board partly out of view") == 0 ? 1 : 0;
    }
    std::printf("| %s | - | %d | %d |\n", none ? "no board" : "board half out of view", named,
                seeds);
    std::fflush(stdout);
  }
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
