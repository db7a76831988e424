// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// `./run bench runtime [DRAWING ...]`: the time of each stage on the embedded scene, beside
/// OpenCV's Scharr and LSD on the same image in the same run; then how the whole grows with pixels,
/// threads, distance range and parts. Drawings given are the parts that are loaded besides.

#include "planar_bin_picking/image/camera_file.h"
#include "planar_bin_picking/locate/locator.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr int kRuns = 7;
const std::string kScene = PACKAGE_DIR "/test/data/bin_bracket_00/";

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Median time of a call in ms.
double timed(const std::function<void()>& call) {
  std::vector<double> ms;
  for (int i = 0; i < kRuns; ++i) {
    const auto start = std::chrono::steady_clock::now();
    call();
    ms.push_back(1e3 *
                 std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return median(ms);
}

struct Setting {
  cv::Mat image;
  Camera camera;
  LocateRequest request;
  int threads = 1;
};

/// Medians in ms by stage, and "locate".
std::map<std::string, double> measure(const Setting& s) {
  LocatorParams params;
  params.threads = s.threads;
  const Locator locator(params);
  std::map<std::string, std::vector<double>> ms;
  for (int i = 0; i < kRuns; ++i) {
    const LocateResult result = locator.locate(s.image, s.camera, s.request);
    for (const auto& stage : result.report.stages) ms[stage.name].push_back(1e3 * stage.seconds);
    ms["locate"].push_back(1e3 * result.report.seconds);
  }
  std::map<std::string, double> out;
  for (const auto& [name, values] : ms) out[name] = median(values);
  return out;
}

void print(const std::string& label, const Setting& s) {
  auto ms = measure(s);
  std::printf("| %-28s | %7d | %6.0f | %6.0f | %6.0f | %6.0f |\n", label.c_str(), s.threads,
              ms["edges"], ms["hough"], ms["refine"], ms["locate"]);
}

/// The scene at another size, same view.
Setting resized(const Setting& s, double scale) {
  Setting out = s;
  cv::resize(s.image, out.image, {}, scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  Camera::Model model = s.camera.model();
  model.width = out.image.cols;
  model.height = out.image.rows;
  model.fx *= scale;
  model.fy *= scale;
  model.cx = (model.cx + 0.5) * scale - 0.5;
  model.cy = (model.cy + 0.5) * scale - 0.5;
  out.camera = Camera(model);
  return out;
}

void compare(const Setting& s) {
  cv::Mat half, dx, dy;
  cv::resize(s.image, half, {}, 0.5, 0.5, cv::INTER_AREA);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  double reference = timed([&] {
    cv::Scharr(half, dx, CV_16S, 1, 0);
    cv::Scharr(half, dy, CV_16S, 0, 1);
  });
  std::printf("Scharr, half size, one thread: %.1f ms\n", reference);
  try {
    const auto lsd = cv::createLineSegmentDetector();
    cv::Mat lines;
    const double ms = timed([&] { lsd->detect(half, lines); });
    reference += ms;
    std::printf("LSD, half size, one thread: %.1f ms\n", ms);
    Setting one = s;
    one.threads = 1;
    std::printf("locate, one thread / (Scharr + LSD): %.2f\n", measure(one)["locate"] / reference);
  } catch (const cv::Exception&) {  // some releases of OpenCV have it taken out
    std::printf("LSD is not in this OpenCV\n");
  }
  cv::setNumThreads(threads);
}

void run(const std::vector<std::string>& drawings) {
  const auto load = [](const std::string& path) {
    return std::make_shared<const PartModel>(loadPartFile(path));
  };
  const std::string bracket = PACKAGE_DIR "/config/parts/bracket.yaml";
  Setting s{cv::imread(kScene + "image.png", cv::IMREAD_GRAYSCALE),
            loadCamera(kScene + "camera_info.yaml"), LocateRequest{}, 2};
  s.request.parts = {load(bracket)};
  s.request.distance_min = 0.785;
  s.request.distance_max = 0.98;
  std::printf("loading a part: %.0f ms\n", timed([&] { load(bracket); }));
  compare(s);
  std::printf("\n| median ms of %d                |", kRuns);
  std::printf(" threads |  edges |  hough | refine | locate |\n");
  std::printf("|---|---|---|---|---|---|\n");
  print("embedded scene, 5 Mpx", s);
  Setting one = s;
  one.threads = 1;
  print("one thread", one);
  for (const double scale : {0.5, 0.7071, 1.4142}) {
    const Setting other = resized(s, scale);
    print(std::to_string(other.image.total() / 100000 / 10.0).substr(0, 4) + " Mpx", other);
  }
  for (const double range : {0.5, 2.0}) {
    Setting other = s;
    other.request.distance_min = 0.98 - range * (0.98 - 0.785);
    print(range < 1.0 ? "half the distance range" : "twice the distance range", other);
  }
  Setting many = s;
  for (const auto& path : drawings) {
    many.request.parts.push_back(load(path));
    print(std::to_string(many.request.parts.size()) + " parts", many);
  }
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  try {
    planar_bin_picking::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "runtime: %s\n", error.what());
    return 2;
  }
  return 0;
}
