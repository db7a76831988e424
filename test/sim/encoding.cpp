// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/encoding.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <cstdint>
#include <stdexcept>
#include <vector>

namespace planar_bin_picking::cell {
namespace {

// What colour sensors' data sheets show about for white light, green = 1.
constexpr double kRed = 0.6, kBlue = 0.55;

struct Pattern {
  const char* name;  ///< by the first pixels, as cameras and ROS name it
  int code;          ///< OpenCV names it by the second and third pixel of the second row
};
constexpr Pattern kPatterns[] = {{"RGGB", cv::COLOR_BayerBG2BGR},
                                 {"GRBG", cv::COLOR_BayerGB2BGR},
                                 {"GBRG", cv::COLOR_BayerGR2BGR},
                                 {"BGGR", cv::COLOR_BayerRG2BGR}};

int demosaicingOf(const std::string& bayer) {
  for (const Pattern& pattern : kPatterns)
    if (bayer == pattern.name) return pattern.code;
  throw std::invalid_argument("bayer is '" + bayer +
                              "': must be RGGB, GRBG, GBRG or BGGR, or empty for a grey camera");
}

}  // namespace

void check(const Encoding& encoding) {
  constexpr int kBest = 100;
  if (!encoding.bayer.empty()) demosaicingOf(encoding.bayer);
  if (encoding.jpeg_quality < 0 || encoding.jpeg_quality > kBest) {
    throw std::invalid_argument("jpeg_quality is " + std::to_string(encoding.jpeg_quality) +
                                ": must lie in 1 .. 100, or be 0 for no JPEG");
  }
}

double filterShare(const Encoding& encoding, int x, int y) {
  if (encoding.bayer.empty()) return 1.0;
  const char colour = encoding.bayer[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
  return colour == 'R' ? kRed : colour == 'B' ? kBlue : 1.0;
}

cv::Mat encode(const cv::Mat& pixels, const Encoding& encoding) {
  check(encoding);
  cv::Mat grey = pixels;
  if (!encoding.bayer.empty()) {
    cv::Mat colours;
    cv::cvtColor(pixels, colours, demosaicingOf(encoding.bayer));
    cv::cvtColor(colours, grey, cv::COLOR_BGR2GRAY);
  }
  if (encoding.jpeg_quality == 0) return grey;
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".jpg", grey, bytes, {cv::IMWRITE_JPEG_QUALITY, encoding.jpeg_quality}))
    throw std::runtime_error("this OpenCV cannot write JPEG");
  return cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
}

}  // namespace planar_bin_picking::cell
