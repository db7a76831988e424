// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Whole simulated calibrations over many seeds, half of them eye-in-hand: `calibration [SEEDS]`
/// prints the table in calibration.md. 10 % of the poses are unreachable, 2 % of the moves fail.

#include "hand_eye_start.h"
#include "support/simulated_run.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace planar_bin_picking {
namespace {

struct Errors {
  std::vector<double> mm, deg, fx, park_mm, park_deg, sigma_t, sigma_r, views, seconds;
  int lost = 0, good = 0, runs = 0;
};

double at(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

/// Park's closed form, as OpenCV has it, on the same views with the same intrinsics.
void addPark(const RunWorld& world, const RunOutcome& outcome, Errors* errors) {
  std::vector<Motion> motions;
  for (std::size_t i = 0; i < outcome.problem.sightings.size(); ++i) {
    const Sighting& s = outcome.problem.sightings[i];
    const auto pose = boardPose(outcome.result.camera, outcome.problem.board, s.corners);
    if (pose) motions.push_back({robotSide(outcome.problem.mounting, s.T_base_flange), *pose});
  }
  const auto chains =
      closedForms(outcome.problem, motions, fromModel(outcome.result.camera), {}, false);
  // The own form comes first, then Park's.
  const Vector6d error = log(chains.at(1).T_mount_camera.inverse() * world.cell.T_mount_camera);
  errors->park_mm.push_back(1e3 * error.head<3>().norm());
  errors->park_deg.push_back(error.tail<3>().norm() / sim::kDegree);
}

void addRun(unsigned seed, double robot_mm, double robot_deg, Errors* errors) {
  RunWorld world(seed % 2 == 0, seed);
  world.cell.robot_mm = robot_mm;
  world.cell.robot_deg = robot_deg;
  world.unreachable = 0.1;
  world.failing = 0.02;
  HandEyeParams solver;
  solver.tolerance_mm = 0.001;  // never small enough: all views are taken
  const auto start = std::chrono::steady_clock::now();
  const RunOutcome outcome = world.run(RunParams(), solver);
  const HandEyeResult& result = outcome.result;
  ++errors->runs;
  errors->lost += outcome.lost;
  if (!result.solved || result.verdict == Verdict::kRefused) {
    std::printf("  seed %u refused: %s\n", seed, result.reasons.at(0).c_str());
    return;
  }
  ++errors->good;
  errors->seconds.push_back(
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  const Vector6d error = log(result.T_mount_camera.inverse() * world.cell.T_mount_camera);
  const Matrix6d covariance = result.covariance.block<6, 6>(kHandEye, kHandEye);
  errors->mm.push_back(1e3 * error.head<3>().norm());
  errors->deg.push_back(error.tail<3>().norm() / sim::kDegree);
  errors->fx.push_back(100.0 * std::abs(result.camera.fx / world.cell.camera.fx - 1.0));
  errors->views.push_back(outcome.pictures);
  errors->sigma_t.push_back(error.head<3>().norm() /
                            std::sqrt(covariance.topLeftCorner<3, 3>().trace()));
  errors->sigma_r.push_back(error.tail<3>().norm() /
                            std::sqrt(covariance.bottomRightCorner<3, 3>().trace()));
  addPark(world, outcome, errors);
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 100;
  std::printf(
      "| robot | runs | solved | views | lost | mm median / p95 | deg median / p95 | fx %% p95 | "
      "Park mm median / p95 | Park deg median | error/sigma mm, deg | s |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [mm, deg] : {std::pair(0.0, 0.0), {0.1, 0.02}, {1.0, 0.1}}) {
    Errors e;
    for (int seed = 1; seed <= seeds; ++seed) addRun(static_cast<unsigned>(seed), mm, deg, &e);
    std::printf(
        "| %.1f mm / %.2f deg | %d | %d | %.1f | %d | %.3f / %.3f | %.4f / %.4f | %.4f | "
        "%.3f / %.3f | %.4f | %.2f, %.2f | %.1f |\n",
        mm, deg, e.runs, e.good, mean(e.views), e.lost, at(e.mm, 0.5), at(e.mm, 0.95),
        at(e.deg, 0.5), at(e.deg, 0.95), at(e.fx, 0.95), at(e.park_mm, 0.5), at(e.park_mm, 0.95),
        at(e.park_deg, 0.5), mean(e.sigma_t), mean(e.sigma_r), mean(e.seconds));
    std::fflush(stdout);
  }
  return 0;
}
