// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Whether the stated sigma is honest on real pictures, whose truth nobody knows: halves of one
/// set, drawn at random, are calibrated each by itself, and their squared difference is held
/// against the sum of the stated variances. `calibration_splits BOARD SQUARE MODE SAMPLES [SPLITS
/// [ROBOT_MM ROBOT_DEG]]`

#include "calibrate/samples_file.h"
#include "planar_bin_picking/calibrate/board/find_board.h"
#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace planar_bin_picking {
namespace {

HandEyeProblem look(const Board& board, bool in_hand, const std::vector<Sample>& samples) {
  constexpr double kBlurMax = 5.0;
  HandEyeProblem problem;
  problem.mounting = in_hand ? Mounting::kEyeInHand : Mounting::kEyeToHand;
  problem.board = board;
  for (const Sample& sample : samples) {
    const cv::Mat image = cv::imread(sample.image.string(), cv::IMREAD_GRAYSCALE);
    problem.width = image.cols;
    problem.height = image.rows;
    const BoardObservation seen = findBoard(image, board, kBlurMax);
    if (seen.status != BoardObservation::Status::kFound) continue;
    problem.observations.push_back({sample.name, sample.T_base_flange, seen.corners});
  }
  return problem;
}

struct Sums {
  double ratio_mm = 0.0, ratio_deg = 0.0, apart_mm = 0.0, apart_deg = 0.0;
  int pairs = 0;
};

void addSplit(const HandEyeProblem& problem, const HandEyeParams& params, std::mt19937* random,
              Sums* sums) {
  HandEyeProblem halves[2] = {problem, problem};
  std::vector<Observation> all = problem.observations;
  std::shuffle(all.begin(), all.end(), *random);
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  halves[0].observations.assign(all.begin(), middle);
  halves[1].observations.assign(middle, all.end());
  const HandEyeResult a = solveHandEye(halves[0], params), b = solveHandEye(halves[1], params);
  if (!a.solved || !b.solved) return;
  const Vector6d apart = log(a.T_mount_camera.inverse() * b.T_mount_camera);
  const Matrix6d stated = (a.covariance + b.covariance).block<6, 6>(kHandEye, kHandEye);
  const double mm2 = apart.head<3>().squaredNorm(), deg2 = apart.tail<3>().squaredNorm();
  sums->ratio_mm += mm2 / stated.topLeftCorner<3, 3>().trace();
  sums->ratio_deg += deg2 / stated.bottomRightCorner<3, 3>().trace();
  sums->apart_mm += 1e6 * mm2;
  sums->apart_deg += deg2;
  ++sums->pairs;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  if (argc < 5) {
    std::fprintf(stderr,
                 "usage: calibration_splits BOARD SQUARE eye_in_hand|eye_to_hand SAMPLES "
                 "[SPLITS [ROBOT_MM ROBOT_DEG]]\n");
    return 2;
  }
  const Board board = parseBoard(argv[1], std::atof(argv[2]));
  const HandEyeProblem problem =
      look(board, std::string(argv[3]) == "eye_in_hand", loadSamples(argv[4]));
  HandEyeParams params;
  params.min_views = 6;
  if (argc > 7) {
    params.robot_sigma_mm = std::atof(argv[6]);
    params.robot_sigma_deg = std::atof(argv[7]);
  }
  Sums sums;
  std::mt19937 random(1);
  const int splits = argc > 5 ? std::atoi(argv[5]) : 100;
  for (int i = 0; i < splits; ++i) addSplit(problem, params, &random, &sums);
  const double n = std::max(1, sums.pairs);
  std::printf(
      "%zu views, %d splits: apart %.2f mm %.3f deg RMS; squared difference / stated "
      "variance %.2f (mm) %.2f (deg)\n",
      problem.observations.size(), sums.pairs, std::sqrt(sums.apart_mm / n),
      57.29578 * std::sqrt(sums.apart_deg / n), sums.ratio_mm / n, sums.ratio_deg / n);
  return 0;
}
