// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Calibrates camera and hand-eye from pictures and robot poses on disk, with no ROS master.
/// Exit status: 0 GOOD or POOR; 3 REFUSED; 2, with one line on stderr, on bad input.

#include "calibrate/samples_file.h"
#include "command_line.h"
#include "read_image.h"

#include "planar_bin_picking/calibrate/board/board_file.h"
#include "planar_bin_picking/calibrate/board/find_board.h"
#include "planar_bin_picking/calibrate/board/missing_board.h"
#include "planar_bin_picking/calibrate/calibration_file.h"
#include "planar_bin_picking/image/camera_file.h"

#include <filesystem>
#include <limits>

namespace planar_bin_picking {
namespace {

const char kName[] = "calibrate_samples";

double numberOf(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  double number = std::numeric_limits<double>::quiet_NaN();
  in >> number;
  return (in >> std::ws).eof() ? number : std::numeric_limits<double>::quiet_NaN();
}

std::string wrongNumber(const std::string& text) {
  return std::isfinite(numberOf(text)) ? "" : "is \"" + text + "\", must be a number";
}

struct Options {
  std::string board, board_file, mode, samples, camera_info, output;
  double square = 0.0;
  std::string replace_good = "no";
  std::string board_z;  // "" = the robot turns about several axes
};

void addOptions(CLI::App* app, Options* options) {
  auto* const board =
      app->add_option("--board", options->board,
                      "inner corners of a checkerboard, along its rows x along its columns")
          ->type_name("CxR");
  auto* const square = app->add_option("--square", options->square, "side of a square, metres")
                           ->type_name("M")
                           ->check(wrongMetres);
  auto* const file = app->add_option("--board-file", options->board_file,
                                     "in place of these two: the board as YAML, also with markers "
                                     "(ChArUco)")
                         ->type_name("F")
                         ->check(wrongPath);
  board->needs(square)->excludes(file);
  square->needs(board)->excludes(file);
  app->add_option("--mode", options->mode,
                  "eye_in_hand: the camera is on the flange, the board stands still; eye_to_hand: "
                  "the camera stands still, the board is on the flange")
      ->required()
      ->type_name("MODE")
      ->check(CLI::IsMember({"eye_in_hand", "eye_to_hand"}));
  app->add_option("--samples", options->samples,
                  "list of {image: path, position: [x, y, z], orientation: [x, y, z, w]}, "
                  "T_base_flange in metres; paths are relative to this file")
      ->required()
      ->type_name("F")
      ->check(wrongPath);
  app->add_option("--camera-info", options->camera_info,
                  "intrinsics to hold fixed, as ROS writes them; otherwise estimated")
      ->type_name("F")
      ->check(wrongPath);
  app->add_option("--output", options->output,
                  "gets calibration.yaml and report.html, and unless the verdict is REFUSED "
                  "camera_info.yaml and hand_eye.yaml")
      ->required()
      ->type_name("DIR")
      ->check(wrongPath);
  app->add_option("--replace-good", options->replace_good,
                  "yes: a POOR calibration replaces a GOOD one in DIR; no: it goes to DIR/poor")
      ->type_name("yes|no")
      ->check(CLI::IsMember({"yes", "no"}));
  app->add_option("--board-z", options->board_z,
                  "for a robot that turns about the base's z axis alone: height of the middle of "
                  "the board's inner corners, as the robot touched it, in the base's frame, or in "
                  "the flange's for a board on the flange, metres")
      ->type_name("M")
      ->check(wrongNumber);
  app->footer("Exit status: 0 GOOD or POOR; 3 REFUSED; 2, with one line on stderr, on bad input.");
}

/// What the pictures show.
struct Seen {
  HandEyeProblem problem;
  struct Useless {
    const Sample* sample;
    std::string why;
    std::string text() const { return sample->name + ": " + why; }
  };
  std::vector<Useless> without_board;
};

cv::Mat loadImage(const std::filesystem::path& path) {
  return readImage(path.string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
}

const char kNoBoard[] = "no board found";

Seen look(const std::vector<Sample>& samples, const Board& board, Mounting mounting) {
  Seen seen;
  seen.problem.mounting = mounting;
  seen.problem.board = board;
  for (const Sample& sample : samples) {
    const cv::Mat image = loadImage(sample.image);
    if (seen.problem.width == 0) {
      seen.problem.width = image.cols;
      seen.problem.height = image.rows;
    }
    if (image.cols != seen.problem.width || image.rows != seen.problem.height) {
      throw std::runtime_error(sample.name + ": is " + std::to_string(image.cols) + " x " +
                               std::to_string(image.rows) + ", the first picture is " +
                               std::to_string(seen.problem.width) + " x " +
                               std::to_string(seen.problem.height) + "; all must be of one camera");
    }
    const BoardObservation observation = findBoard(image, board, kBlurMaxPx);
    if (observation.status == BoardObservation::Status::kFound) {
      seen.problem.observations.push_back(
          {sample.name, sample.T_base_flange, observation.corners, observation.ids});
    } else {
      const bool blurred = observation.status == BoardObservation::Status::kBlurred;
      seen.without_board.push_back({&sample, blurred ? "blurred" : kNoBoard});
    }
  }
  return seen;
}

/// Why the pictures show no board: of most of them one reason, of a few each its own, "board partly
/// out of view".
std::string whyMissing(Seen* seen, bool most) {
  constexpr std::size_t kAskedMost = 6;  // each takes its time
  const Board& board = seen->problem.board;
  std::vector<cv::Mat> images;
  for (Seen::Useless& useless : seen->without_board) {
    if (images.size() == kAskedMost) break;
    if (useless.why != kNoBoard && !most) continue;
    images.push_back(loadImage(useless.sample->image));
    if (most) continue;
    const std::string why = whyBoardIsMissing({images.back()}, board);
    useless.why = why.substr(0, why.find(':'));
  }
  return most ? whyBoardIsMissing(images, board) + "; " : "";
}

/// Adds to the reasons what the solver cannot know: why pictures show no board.
void explainMissingBoards(std::size_t samples, Seen* seen, HandEyeResult* result) {
  const std::size_t missing = seen->without_board.size();
  if (missing == 0) return;
  // Where most pictures lack it, all other reasons follow from that.
  const bool most = 2 * missing > samples;
  const std::string why = whyMissing(seen, most);
  // On its own a missing board is no flaw of a result that is good.
  if (result->verdict == Verdict::kGood) return;
  const std::string count = std::to_string(missing) + " of " + std::to_string(samples);
  const std::string reason = why +
                             (samples == 1   ? "the only picture shows"
                              : missing == 1 ? count + " pictures shows"
                                             : count + " pictures show") +
                             " no usable board of " + std::to_string(seen->problem.board.cols) +
                             "x" + std::to_string(seen->problem.board.rows) + " inner corners (" +
                             seen->without_board.front().text() + ")";
  result->reasons.insert(most ? result->reasons.begin() : result->reasons.end(), reason);
}

void print(const HandEyeResult& result, const Seen& seen) {
  std::printf("%s: %d views used\n", nameOf(result.verdict), result.views_used);
  for (const std::string& reason : result.reasons) std::printf("  - %s\n", reason.c_str());
  for (const Seen::Useless& useless : seen.without_board) {
    std::printf("  %s\n", useless.text().c_str());
  }
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    if (result.views[i].used || result.views[i].why_not.empty()) continue;
    std::printf("  %s: not used: %s\n", seen.problem.observations[i].name.c_str(),
                result.views[i].why_not.c_str());
  }
  for (const std::string& note : result.notes) std::printf("  note: %s\n", note.c_str());
  if (!result.solved) return;
  const Eigen::Vector3d t = result.T_mount_camera.translation();
  std::printf("%s [%.6f %.6f %.6f] m\n", result.transform_name.c_str(), t.x(), t.y(), t.z());
  std::printf("fx %.3f fy %.3f cx %.3f cy %.3f\n", result.camera.fx, result.camera.fy,
              result.camera.cx, result.camera.cy);
  std::printf("residual %.3f px, chain %.3f px, floor %.3f px; robot noise %.3f mm %.4f deg\n",
              result.rms_px, result.chain_px, result.pnp_floor_px, result.robot_mm,
              result.robot_deg);
  std::printf(
      "expected error %.3f mm %.4f deg at %.3f m, with the robot's noise %.3f mm %.4f deg\n",
      result.expected_error_mm, result.expected_error_deg, result.working_distance,
      result.with_robot_mm, result.with_robot_deg);
}

int run(const Options& options) {
  if (options.board.empty() && options.board_file.empty()) {
    throw std::invalid_argument("give --board and --square, or --board-file");
  }
  const Board board = options.board_file.empty() ? parseBoard(options.board, options.square)
                                                 : loadBoard(options.board_file);
  const Mounting mounting =
      options.mode == "eye_in_hand" ? Mounting::kEyeInHand : Mounting::kEyeToHand;
  const std::vector<Sample> samples = loadSamples(options.samples);
  std::optional<Camera::Model> camera;
  if (!options.camera_info.empty()) camera = loadCamera(options.camera_info).model();
  Seen seen = look(samples, board, mounting);
  seen.problem.camera = camera;
  HandEyeParams params;
  params.four_axis = !options.board_z.empty();
  if (params.four_axis) params.board_z = numberOf(options.board_z);
  HandEyeResult result = solveHandEye(seen.problem, params);
  explainMissingBoards(samples.size(), &seen, &result);
  CalibrationNames names;
  if (mounting == Mounting::kEyeToHand) names.mount_frame = "base";
  SaveOptions save;
  save.replace_good = options.replace_good == "yes";
  save.pictures = std::filesystem::absolute(options.samples).parent_path().string() + "/";
  const std::string folder = saveCalibration(options.output, seen.problem, result, names, save);
  print(result, seen);
  std::printf("written to %s\n", std::filesystem::absolute(folder).lexically_normal().c_str());
  constexpr int kRefused = 3;
  return result.verdict == Verdict::kRefused ? kRefused : kDone;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  Options options;
  CLI::App app("Calibrates camera and hand-eye from pictures and robot poses on disk.", kName);
  addOptions(&app, &options);
  return runTool(&app, argc, argv, [&] { return run(options); });
}
