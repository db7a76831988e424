// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Locates parts in one picture on disk, with no ROS master.
/// Exit status: 0, even if nothing was found; 2, with one line on stderr, on bad input.

#include "planar_bin_picking/locator.h"
#include "planar_bin_picking/overlay.h"

#include <yaml-cpp/yaml.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <locale>
#include <map>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

const char kUsage[] =
    "usage: locate_image --part P [--part P2 ...] --camera camera_info.yaml --image I\n"
    "                    --distance-min M --distance-max M [--params F] [--output result.yaml]\n"
    "                    [--overlay overlay.png]\n"
    "\n"
    "  --part P            a part: its .dxf or its .yaml; may be given several times\n"
    "  --camera F          the camera's calibration, as ROS writes it\n"
    "  --image F           the picture: 8 or 16 bit, grey or colour, of the calibrated size\n"
    "  --distance-min M    metres along the optical axis to the nearest a part may lie\n"
    "  --distance-max M    metres to the farthest: the floor of the bin\n"
    "  --params F          parameters over the defaults, as config/locator.yaml\n"
    "  --output F          writes the result as YAML, metres, camera frame\n"
    "  --overlay F         writes the picture with the result drawn over it\n";

constexpr double kDegreesPerRadian = 180.0 / 3.14159265358979323846;

struct Options {
  std::vector<std::string> parts;
  std::string camera, image, params, output, overlay;
  double distance_min = 0.0, distance_max = 0.0;
  bool help = false;
};

double metres(const std::string& option, const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  double value = 0.0;
  if (!(in >> value) || !(in >> std::ws).eof() || !std::isfinite(value) || value <= 0.0) {
    throw std::invalid_argument(option + " is \"" + text + "\", must be metres greater than 0");
  }
  return value;
}

void checkComplete(const Options& options) {
  const auto require = [](bool given, const char* option) {
    if (!given) throw std::invalid_argument(std::string(option) + " is missing; see --help");
  };
  require(!options.parts.empty(), "--part");
  require(!options.camera.empty(), "--camera");
  require(!options.image.empty(), "--image");
  require(options.distance_min > 0.0, "--distance-min");
  require(options.distance_max > 0.0, "--distance-max");
  if (options.distance_min > options.distance_max) {
    throw std::invalid_argument("--distance-min is greater than --distance-max");
  }
}

Options parseOptions(const std::vector<std::string>& arguments) {
  Options options;
  const std::map<std::string, std::string*> texts = {{"--camera", &options.camera},
                                                     {"--image", &options.image},
                                                     {"--params", &options.params},
                                                     {"--output", &options.output},
                                                     {"--overlay", &options.overlay}};
  const std::map<std::string, double*> distances = {{"--distance-min", &options.distance_min},
                                                    {"--distance-max", &options.distance_max}};
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& option = arguments[i];
    if (option == "--help" || option == "-h") {
      options.help = true;
      return options;
    }
    const bool known = option == "--part" || texts.count(option) + distances.count(option) > 0;
    if (!known) throw std::invalid_argument("unknown option \"" + option + "\"; see --help");
    if (++i == arguments.size() || arguments[i].empty())
      throw std::invalid_argument(option + " needs a value; see --help");
    if (option == "--part") {
      options.parts.push_back(arguments[i]);
    } else if (texts.count(option) != 0) {
      *texts.at(option) = arguments[i];
    } else {
      *distances.at(option) = metres(option, arguments[i]);
    }
  }
  checkComplete(options);
  return options;
}

std::vector<std::shared_ptr<const PartModel>> loadParts(const std::vector<std::string>& paths) {
  std::vector<std::shared_ptr<const PartModel>> parts;
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

/// Any 8- or 16-bit picture as one grey channel.
cv::Mat loadImage(const std::string& path) {
  const cv::Mat image = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (image.empty())
    throw std::runtime_error(path + ": cannot be read as a picture; check the path and the file");
  if (image.depth() != CV_8U && image.depth() != CV_16U) {
    throw std::runtime_error(path + ": has neither 8 nor 16 bit; save it as PNG");
  }
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (image.channels() == 4) cv::cvtColor(image, grey, cv::COLOR_BGRA2GRAY);
  return grey;
}

const char* nameOf(Face face) { return face == Face::kFront ? "front" : "back"; }

void writeResult(const std::string& path, const LocateResult& result, double threshold) {
  YAML::Emitter out;
  out.SetDoublePrecision(9);
  out << YAML::BeginMap << YAML::Key << "seconds" << YAML::Value << result.report.seconds;
  out << YAML::Key << "threshold" << YAML::Value << threshold;
  out << YAML::Key << "detections" << YAML::Value << YAML::BeginSeq;
  for (const Detection& detection : result.detections) {
    const Eigen::Vector3d p = detection.T_camera_part.translation();
    Eigen::Quaterniond q(detection.T_camera_part.rotation());
    q.normalize();
    if (q.w() < 0.0) q.coeffs() *= -1.0;
    out << YAML::Flow << YAML::BeginMap;
    out << YAML::Key << "part" << YAML::Value << detection.part_name;
    out << YAML::Key << "face" << YAML::Value << nameOf(detection.face);
    out << YAML::Key << "position" << YAML::Value << YAML::Flow
        << std::vector<double>{p.x(), p.y(), p.z()};
    out << YAML::Key << "orientation" << YAML::Value << YAML::Flow
        << std::vector<double>{q.x(), q.y(), q.z(), q.w()};
    out << YAML::Key << "score" << YAML::Value << detection.score;
    out << YAML::Key << "visible_fraction" << YAML::Value << detection.visible_fraction
        << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  std::ofstream file(path);
  file << out.c_str() << "\n";
  file.close();
  if (!file)
    throw std::runtime_error(path + ": cannot be written; check the path and its permissions");
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
void checkWritable(const Options& options) {
  for (const std::string& path : {options.output, options.overlay}) {
    if (path.empty()) continue;
    const auto folder = std::filesystem::absolute(path).parent_path();
    if (std::filesystem::is_directory(folder)) continue;
    throw std::runtime_error(path + ": cannot be written; there is no folder " + folder.string());
  }
  if (!options.overlay.empty() && !cv::haveImageWriter(options.overlay)) {
    throw std::runtime_error(options.overlay + ": cannot be written; end its name in .png or .jpg");
  }
}

void run(const Options& options) {
  checkWritable(options);
  const auto start = std::chrono::steady_clock::now();
  const Camera camera = loadCamera(options.camera);
  const Locator locator(options.params.empty() ? LocatorParams()
                                               : loadLocatorParams(options.params));
  LocateRequest request;
  request.parts = loadParts(options.parts);
  request.distance_min = options.distance_min;
  request.distance_max = options.distance_max;
  const cv::Mat image = loadImage(options.image);
  const std::chrono::duration<double> loading = std::chrono::steady_clock::now() - start;
  const LocateResult result = locator.locate(image, camera, request);
  printTable(result);
  printTimes(result.report, loading.count());
  if (!options.output.empty())
    writeResult(options.output, result, locator.params().score.threshold);
  if (!options.overlay.empty() &&
      !cv::imwrite(options.overlay, drawOverlay(image, camera, request.parts, result.detections))) {
    throw std::runtime_error(options.overlay +
                             ": cannot be written; check the path and its permissions");
  }
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  try {
    const Options options = parseOptions({argv + 1, argv + argc});
    if (options.help) {
      std::fputs(kUsage, stdout);
      return 0;
    }
    run(options);
    return 0;
  } catch (const std::exception& e) {
    std::string line = e.what();
    std::replace(line.begin(), line.end(), '\n', ' ');
    std::fprintf(stderr, "locate_image: %s\n", line.c_str());
    return 2;
  }
}
