// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Simulated calibrations over many seeds: `calibration [SEEDS [TABLE]]` prints the tables in
/// calibration.md, or one of them: runs, mistakes, refusals, park or drawn. Whole runs that choose
/// their own views, half of them eye-in-hand; the same with drawn pictures; the solver against
/// OpenCV's Park; and what must be refused.

#include "calibration_park.h"
#include "calibration_refusals.h"
#include "support/simulated_run.h"

#include <cstdlib>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace planar_bin_picking {
namespace {

struct Runs {
  Errors errors;
  std::vector<double> pictures;
  int runs = 0, lost = 0, saved = 0;
};

/// @param all_views  the wanted error is out of reach, so that all views are taken
void addRun(unsigned seed, const Robot& robot, bool all_views, Runs* out) {
  RunWorld world(seed % 2 == 0, seed);
  world.cell.robot_mm = robot.mm;
  world.cell.robot_deg = robot.deg;
  world.unreachable = 0.1;
  world.failing = 0.02;
  HandEyeParams solver;
  if (all_views) solver.tolerance_mm = 0.001;
  const RunOutcome outcome = world.run(wideRun(), solver);
  ++out->runs;
  out->lost += outcome.lost;
  if (outcome.result.verdict == Verdict::kRefused) {
    std::printf("seed %u refused: %s\n", seed, outcome.result.reasons.at(0).c_str());
    return;
  }
  ++out->saved;
  out->pictures.push_back(outcome.pictures);
  out->errors.add(world.cell, outcome.result);
}

void printErrors(const Errors& e) {
  std::printf(" %.3f / %.3f | %.4f / %.4f | %.4f | %.2f, %.2f | %.2f, %.2f |\n",
              quantile(e.mm, 0.5), quantile(e.mm, 0.95), quantile(e.deg, 0.5),
              quantile(e.deg, 0.95), quantile(e.fx_percent, 0.95), mean(e.by_sigma_mm),
              mean(e.by_sigma_deg), mean(e.by_expected_mm), mean(e.by_expected_deg));
  std::fflush(stdout);
}

const char kErrorColumns[] =
    "mm median / p95 | deg median / p95 | fx %% p95 | error/sigma mm, deg | at the bin mm, deg |\n";

void printRuns(int seeds) {
  std::printf("| robot | views | runs | saved | pictures mean / most | lost | ");
  std::printf(kErrorColumns);
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const bool all_views : {true, false}) {
    for (const Robot& robot : kRobots) {
      Runs runs;
      for (int seed = 1; seed <= seeds; ++seed) {
        addRun(static_cast<unsigned>(seed), robot, all_views, &runs);
      }
      std::printf("| %.1f mm / %.2f deg | %s | %d | %d | %.1f / %.0f | %d |", robot.mm, robot.deg,
                  all_views ? "all 15" : "until 1 mm", runs.runs, runs.saved, mean(runs.pictures),
                  quantile(runs.pictures, 1.0), runs.lost);
      printErrors(runs.errors);
    }
  }
}

/// Random views, drawn with blur and grain, and found again by the detector; true robot poses.
HandEyeProblem drawnProblem(const sim::BoardCell& cell, std::mt19937* random) {
  HandEyeProblem problem = emptyProblem(cell);
  std::vector<Eigen::Vector2d> corners;
  while (problem.observations.size() < 15) {
    const auto T_camera_board = sim::randomView(cell, 0.43, 35.0, 0.6, random);
    if (!sim::seeCorners(cell, T_camera_board, random, &corners)) continue;
    const int number = static_cast<int>(problem.observations.size()) + 1;
    const cv::Mat image = sim::takeBoardImage(cell, T_camera_board, 0.8, 3.0, number);
    const BoardObservation observation = findBoard(image, problem.board, 4.0);
    if (observation.status != BoardObservation::Status::kFound) continue;
    problem.observations.push_back(
        {"view " + std::to_string(number), cell.flangeFor(T_camera_board), observation.corners});
  }
  return problem;
}

void printDrawn(int seeds) {
  std::printf("\n| robot | drawn, 5 Mpx | corner noise px | ");
  std::printf(kErrorColumns);
  std::printf("|---|---|---|---|---|---|---|---|\n");
  std::vector<Errors> errors(kRobots.size());
  std::vector<std::vector<double>> sigma(kRobots.size());
  for (int seed = 1; seed <= seeds; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed) + 500);
    sim::BoardCell cell = sim::makeCell(seed % 2 == 0, &random);
    const HandEyeProblem drawn = drawnProblem(cell, &random);
    for (std::size_t i = 0; i < kRobots.size(); ++i) {
      cell.robot_mm = kRobots[i].mm;
      cell.robot_deg = kRobots[i].deg;
      HandEyeProblem problem = drawn;
      for (Observation& s : problem.observations) {
        s.T_base_flange = sim::reported(cell, s.T_base_flange, &random);
      }
      const HandEyeResult result = solveHandEye(problem, {});
      if (result.verdict == Verdict::kRefused) continue;
      errors[i].add(cell, result);
      sigma[i].push_back(result.sigma_px);
    }
  }
  for (std::size_t i = 0; i < kRobots.size(); ++i) {
    std::printf("| %.1f mm / %.2f deg | %zu of %d | %.3f |", kRobots[i].mm, kRobots[i].deg,
                errors[i].mm.size(), seeds, mean(sigma[i]));
    printErrors(errors[i]);
  }
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 100;
  if (seeds < 1) {
    std::fprintf(stderr, "calibration: SEEDS is \"%s\", must be a number greater than 0\n",
                 argv[1]);
    return 2;
  }
  const std::string only = argc > 2 ? argv[2] : "";
  const int drawn = std::max(1, seeds / 5);  // pictures take their time
  const std::vector<std::pair<std::string, std::function<void()>>> tables{
      {"runs", [&] { printRuns(seeds); }},
      {"mistakes",
       [&] {
         printMistakes(seeds);
         printMissingBoards(seeds);
       }},
      {"refusals", [&] { printRefusals(seeds); }},
      {"park", [&] { printPark(seeds); }},
      {"drawn", [&] { printDrawn(drawn); }}};
  bool is_known = only.empty();
  for (const auto& [name, print] : tables) {
    if (!only.empty() && name != only) continue;
    is_known = true;
    print();
  }
  if (is_known) return 0;
  std::fprintf(stderr,
               "calibration: TABLE is \"%s\", must be runs, mistakes, refusals, park or drawn\n",
               only.c_str());
  return 2;
}
