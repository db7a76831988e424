// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Locates parts in one picture on disk, with no ROS master.
/// Exit status: 0, even if nothing was found; 2, with one line on stderr, on bad input.

#include "base/yaml_text.h"
#include "command_line.h"
#include "more_views.h"
#include "read_image.h"

#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/image/camera_file.h"
#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/show/overlay.h"
#include "planar_bin_picking/snapshot/snapshot.h"

#include <unistd.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

const char kName[] = "locate_image";

constexpr double kDegreesPerRadian = 180.0 / 3.14159265358979323846;

struct Options {
  std::vector<std::string> parts, views;
  std::string camera, image, params, output, overlay, snapshot;
  double distance_min = 0.0, distance_max = 0.0;
  std::string face = "any";
  std::size_t max_parts = 0;
};

void addFile(CLI::App* app, const std::string& name, std::string* path, bool required,
             const std::string& what) {
  app->add_option(name, *path, what)->required(required)->type_name("F")->check(wrongPath);
}

void addOptions(CLI::App* app, Options* options) {
  app->add_option("--part", options->parts,
                  "a part: its .dxf or its .yaml; may be given several times")
      ->type_name("P");
  addFile(app, "--camera", &options->camera, false, "the camera's calibration, as ROS writes it");
  addFile(app, "--image", &options->image, false,
          "the picture: 8 or 16 bit, grey or colour, of the calibrated size; it is turned as its "
          "EXIF data say");
  app->add_option("--distance-min", options->distance_min,
                  "metres along the optical axis to the nearest a part may lie")
      ->type_name("M")
      ->check(wrongMetres);
  app->add_option("--distance-max", options->distance_max,
                  "metres to the farthest: the floor of the bin")
      ->type_name("M")
      ->check(wrongMetres);
  app->add_option("--face", options->face,
                  "the side that must be up: front (as drawn), back or any; default any")
      ->type_name("FACE")
      ->check(CLI::IsMember({"front", "back", "any"}));
  app->add_option("--max-parts", options->max_parts, "no more than the N best; default 0: all")
      ->type_name("N")
      ->check(wrongCount);
  app->add_option("--view", options->views,
                  "one more picture, its camera's calibration, and where that camera was as seen "
                  "from the first one (YAML: position, orientation); may be given several times")
      ->type_name("IMAGE CAMERA POSE")
      ->type_size(3)
      ->expected(-1);
  addFile(app, "--snapshot", &options->snapshot, false,
          "the folder of a snapshot, in place of the five options above and of --params");
  addFile(app, "--params", &options->params, false,
          "parameters over the defaults, as config/locator.yaml");
  addFile(app, "--output", &options->output, false,
          "writes the result as YAML, metres, camera frame");
  addFile(app, "--overlay", &options->overlay, false,
          "writes the picture with the result drawn over it");
  app->footer(
      "Exit status: 0, even if nothing was found; 2, with one line on stderr, on bad input.");
}

FaceFilter faceOf(const std::string& word) {
  if (word == "front") return FaceFilter::kFront;
  return word == "back" ? FaceFilter::kBack : FaceFilter::kAny;
}

std::vector<PartPtr> loadParts(const std::vector<std::string>& paths) {
  std::vector<PartPtr> parts;
  for (const std::string& path : paths) {
    auto part = std::make_shared<const PartModel>(loadPartFile(path));
    for (const auto& other : parts) {
      if (other->name() == part->name())
        throw std::invalid_argument("--part " + path + ": a part named \"" + part->name() +
                                    "\" is given twice");
    }
    parts.push_back(part);
  }
  return parts;
}

/// Any 8- or 16-bit picture as one grey channel, as it is shown: a phone stores the pixels as its
/// sensor has them and says in the EXIF data how they have to be turned.
cv::Mat loadImage(const std::string& path, const Camera& camera) {
  const cv::Mat image = readImage(path, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH);
  if (image.depth() != CV_8U && image.depth() != CV_16U) {
    throw std::runtime_error(path + ": has neither 8 nor 16 bit; save it as PNG");
  }
  const int width = camera.model().width, height = camera.model().height;
  if (width != height && image.cols == height && image.rows == width) {
    throw std::runtime_error(path + ": is shown as " + std::to_string(image.cols) + " x " +
                             std::to_string(image.rows) + " pixels, the camera info is for " +
                             std::to_string(width) + " x " + std::to_string(height) +
                             "; calibrate with pictures that are shown the same way up");
  }
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

const char* nameOf(Face face) { return face == Face::kFront ? "front" : "back"; }

std::string toYaml(const Detection& detection) {
  const Eigen::Vector3d p = detection.T_camera_part.translation();
  const Eigen::Quaterniond q = quaternionOf(detection.T_camera_part.rotation());
  // Nanometres; the angle fine enough for a drawing whose origin lies kilometres away.
  return "{part: " + yamlText(detection.part_name) + ", face: " + nameOf(detection.face) +
         ", position: " + yamlList({p.x(), p.y(), p.z()}, 9) +
         ", orientation: " + yamlList({q.x(), q.y(), q.z(), q.w()}, 15) +
         ", score: " + yamlNumber(detection.score, 6) +
         ", visible_fraction: " + yamlNumber(detection.visible_fraction, 6);
}

std::string toYaml(const Looked& looked) {
  return toYaml(looked.detection) + ", views: " + std::to_string(looked.detection.views) +
         ", look: " + nameOf(looked.last.status) + ", moved: " + yamlNumber(looked.last.moved, 6);
}

template <class Entry>
std::string listOf(const std::string& key, const std::vector<Entry>& entries) {
  std::string yaml = "\n" + key + ":";
  if (entries.empty()) yaml += " []";
  for (const Entry& entry : entries) yaml += "\n  - " + toYaml(entry) + "}";
  return yaml;
}

/// Those that further views contradict, or not.
std::vector<Looked> only(const std::vector<Looked>& looked, bool contradicted) {
  std::vector<Looked> out;
  for (const Looked& entry : looked) {
    if ((entry.last.status == LookStatus::kContradicted) == contradicted) out.push_back(entry);
  }
  return out;
}

void writeResult(const std::string& path, const LocateResult& result,
                 const std::vector<Looked>* looked, double threshold) {
  std::string yaml = "seconds: " + yamlNumber(result.report.seconds, 6) +
                     "\nthreshold: " + yamlNumber(threshold, 6);
  if (looked != nullptr) {
    yaml +=
        listOf("detections", only(*looked, false)) + listOf("contradicted", only(*looked, true));
  } else {
    yaml += listOf("detections", result.detections);
  }
  std::ofstream file(path);
  file << yaml << "\n";
  file.close();
  if (!file) {
    throw std::runtime_error(path +
                             ": cannot be written; check the path, its permissions and the disk");
  }
}

/// Tilt is the angle between the part's visible face and the image plane, angle the direction of
/// the part's x axis in the image, counter-clockwise from the image's x axis as one sees it.
void printTable(const LocateResult& result) {
  std::printf("%4s  %-16s %-5s %9s %9s %9s %9s %9s  %5s  %7s\n", "rank", "part", "face", "x mm",
              "y mm", "z mm", "tilt deg", "angle deg", "score", "visible");
  for (std::size_t i = 0; i < result.detections.size(); ++i) {
    const Detection& detection = result.detections[i];
    const Eigen::Matrix3d R = detection.T_camera_part.linear();
    const Eigen::Vector3d mm = 1e3 * detection.T_camera_part.translation();
    const double tilt = std::acos(std::min(1.0, std::abs(R(2, 2)))),
                 angle = std::atan2(-R(1, 0), R(0, 0));
    std::printf("%4zu  %-16s %-5s %9.2f %9.2f %9.2f %9.2f %9.2f  %5.3f  %7.2f\n", i + 1,
                detection.part_name.c_str(), nameOf(detection.face), mm.x(), mm.y(), mm.z(),
                tilt * kDegreesPerRadian, angle * kDegreesPerRadian, detection.score,
                detection.visible_fraction);
  }
  if (result.detections.empty()) std::printf("no part found\n");
}

void printTimes(const Report& report, double loading_seconds) {
  std::printf("\n%-10s %9s  %9s\n", "stage", "ms", "passed on");
  for (const Report::Stage& stage : report.stages) {
    std::printf("%-10s %9.1f  %9zu\n", stage.name.c_str(), 1e3 * stage.seconds, stage.out);
  }
  std::printf("%-10s %9.1f\n%-10s %9.1f\n", "locate", 1e3 * report.seconds, "loading",
              1e3 * loading_seconds);
}

/// Says before the work, not after it, that its result could not be written.
void checkWritable(const std::string& path) {
  const auto fail = [&](const std::string& why) {
    throw std::runtime_error(path + ": cannot be written; " + why);
  };
  const fs::path folder = fs::absolute(path).parent_path();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) fail("it is a folder");
  if (fs::is_fifo(status) || fs::is_socket(status) || fs::is_block_file(status))
    fail("it is no regular file");
  if (fs::exists(status) && access(path.c_str(), W_OK) != 0) fail("check its permissions");
  if (fs::exists(status)) return;
  if (!fs::is_directory(folder, error)) fail("there is no folder " + folder.string());
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    fail("check the permissions of the folder " + folder.string());
}

void checkResults(const Options& options) {
  std::vector<std::string> inputs = options.parts;
  inputs.insert(inputs.end(), {options.camera, options.image, options.params});
  inputs.insert(inputs.end(), options.views.begin(), options.views.end());
  for (const std::string& path : {options.output, options.overlay}) {
    if (path.empty()) continue;
    checkWritable(path);
    for (const std::string& input : inputs) {
      std::error_code error;
      if (input.empty() || !fs::equivalent(path, input, error)) continue;
      throw std::invalid_argument(path + ": cannot be written; it is what is read, too");
    }
  }
  if (!options.output.empty() && options.output == options.overlay)
    throw std::invalid_argument("--output and --overlay are one file, " + options.output);
  if (!options.overlay.empty() && !cv::haveImageWriter(options.overlay)) {
    throw std::runtime_error(options.overlay + ": cannot be written; end its name in .png or .jpg");
  }
}

/// Leaves what the other views do not contradict in the result.
std::vector<Looked> lookAgain(const cv::Mat& image, const Camera& camera,
                              const std::vector<ViewFiles>& files, const LocatorParams& params,
                              const LocateRequest& request, LocateResult* result) {
  double seconds = 0.0;
  const auto looked = lookInViews(image, camera, files, params, request.parts, result->detections,
                                  loadImage, &seconds);
  result->detections.clear();
  for (const Looked& entry : only(looked, false)) result->detections.push_back(entry.detection);
  for (std::size_t i = 0; i < looked.size(); ++i) {
    std::printf("look at %zu: %s, %s\n", i + 1, nameOf(looked[i].last.status),
                looked[i].last.text.c_str());
  }
  result->report.stages.push_back({"views", seconds, result->detections.size()});
  result->report.seconds += seconds;
  return looked;
}

/// The legend, and the pick poses for the faces that are up.
OverlayMore besides(const std::vector<PartPtr>& parts, const std::vector<Detection>& detections) {
  OverlayMore more;
  more.has_legend = true;
  for (const Detection& detection : detections) {
    const FaceFilter up = detection.face == Face::kFront ? FaceFilter::kFront : FaceFilter::kBack;
    for (const PickPose& pick : parts[detection.part]->pickPoses())
      if (pick.face == up || pick.face == FaceFilter::kAny)
        more.T_camera_pick.push_back(detection.T_camera_part * pick.T_part_pick);
  }
  return more;
}

/// What is located, out of the options or out of a snapshot.
struct Task {
  cv::Mat image;
  Camera camera;
  LocatorParams params;
  LocateRequest request;
};

/// What the command line must have, unless there is a snapshot, which must not be mixed with it.
void checkSources(const CLI::App& app, const Options& options) {
  const bool from_snapshot = !options.snapshot.empty();
  for (const char* name : {"--part", "--camera", "--image", "--distance-min", "--distance-max"}) {
    const bool is_given = app.count(name) > 0;
    if (is_given && from_snapshot)
      throw std::invalid_argument(std::string(name) + " is given, and --snapshot has it, too");
    if (!is_given && !from_snapshot) throw CLI::RequiredError(name);
  }
  if (from_snapshot && !options.params.empty())
    throw std::invalid_argument("--params is given, and --snapshot has it, too");
}

Task taskOf(const CLI::App& app, const Options& options) {
  if (!options.snapshot.empty()) {
    Snapshot snapshot = readSnapshot(options.snapshot);
    if (app.count("--face") > 0) snapshot.request.face = faceOf(options.face);
    if (app.count("--max-parts") > 0) snapshot.request.max_parts = options.max_parts;
    return {snapshot.grey, snapshot.camera, snapshot.params, snapshot.request};
  }
  if (options.distance_min > options.distance_max)
    throw std::invalid_argument("--distance-min is " + yamlNumber(options.distance_min) +
                                ", must not be greater than --distance-max, which is " +
                                yamlNumber(options.distance_max));
  const Camera camera = loadCamera(options.camera);
  const LocatorParams params =
      options.params.empty() ? LocatorParams() : loadLocatorParams(options.params);
  LocateRequest request;
  request.parts = loadParts(options.parts);
  request.distance_min = options.distance_min;
  request.distance_max = options.distance_max;
  request.face = faceOf(options.face);
  request.max_parts = options.max_parts;
  return {loadImage(options.image, camera), camera, params, request};
}

int run(const CLI::App& app, const Options& options) {
  checkSources(app, options);
  checkResults(options);
  const auto start = std::chrono::steady_clock::now();
  const Task task = taskOf(app, options);
  const Locator locator(task.params);
  const std::chrono::duration<double> loading = std::chrono::steady_clock::now() - start;
  const auto files = viewFiles(options.views);
  LocateResult result = locator.locate(task.image, task.camera, task.request);
  std::vector<Looked> looked;
  if (!files.empty())
    looked = lookAgain(task.image, task.camera, files, locator.params(), task.request, &result);
  if (!options.output.empty()) {
    writeResult(options.output, result, files.empty() ? nullptr : &looked,
                locator.params().score.threshold);
  }
  if (!options.overlay.empty() &&
      !cv::imwrite(options.overlay,
                   drawOverlay(task.image, task.camera, task.request.parts, result.detections,
                               besides(task.request.parts, result.detections)))) {
    throw std::runtime_error(options.overlay +
                             ": cannot be written; check the path and its permissions");
  }
  printTable(result);
  printTimes(result.report, loading.count());
  return kDone;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  Options options;
  CLI::App app("Locates parts in one picture on disk.", kName);
  addOptions(&app, &options);
  return runTool(&app, argc, argv, [&] { return run(app, options); });
}
