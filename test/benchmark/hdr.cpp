// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// `./run bench hdr`: how long the merge of 4 x 5 Mpx takes, and with a folder of a scene's
/// `exposures/` and a file to write, what it makes of them:
/// `./run bench hdr FOLDER OUT.png [compression [white_percentile]]`.

#include "planar_bin_picking/image/hdr.h"

#include <yaml-cpp/yaml.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace {

using planar_bin_picking::Exposure;

std::vector<Exposure> invented() {
  cv::Mat_<float> light(2048, 2448);
  cv::RNG(1).fill(light, cv::RNG::UNIFORM, 1.0, 120.0);
  std::vector<Exposure> bracket;
  for (const double seconds : {0.002, 0.008, 0.032, 0.128}) {
    bracket.push_back({{}, seconds});
    light.convertTo(bracket.back().image, CV_8U, seconds / 0.008);
  }
  return bracket;
}

std::vector<Exposure> load(const std::string& folder) {
  std::vector<Exposure> bracket;
  for (const auto& entry : YAML::LoadFile(folder + "/exposures.yaml")["exposures"]) {
    const auto file = folder + "/" + entry["file"].as<std::string>();
    bracket.push_back(
        {cv::imread(file, cv::IMREAD_GRAYSCALE), 1e-3 * entry["exposure_ms"].as<double>()});
  }
  return bracket;
}

void measure(const std::vector<Exposure>& bracket, const planar_bin_picking::HdrParams& params) {
  for (const int threads : {1, 2}) {
    std::vector<double> ms;
    for (int i = 0; i < 11; ++i) {
      const auto start = std::chrono::steady_clock::now();
      mergeExposures(bracket, params, threads);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      ms.push_back(1e3 * took.count());
    }
    std::sort(ms.begin(), ms.end());
    std::printf("%zu x %.1f Mpx, %d threads: median %.0f ms, largest %.0f ms\n", bracket.size(),
                1e-6 * static_cast<double>(bracket[0].image.total()), threads, ms[5], ms[10]);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    planar_bin_picking::HdrParams params;
    if (argc > 3) params.compression = std::stod(argv[3]);
    if (argc > 4) params.white_percentile = std::stod(argv[4]);
    const auto bracket = argc > 1 ? load(argv[1]) : invented();
    measure(bracket, params);
    if (argc > 2) cv::imwrite(argv[2], mergeExposures(bracket, params, 2));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hdr: %s\n", error.what());
    return 2;
  }
}
