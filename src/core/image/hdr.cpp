// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/hdr.h"

#include "base/parallel.h"
#include "planar_bin_picking/image/grey.h"

#include <opencv2/core.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>

namespace planar_bin_picking {
namespace {

constexpr int kBand = 64;        // rows that one thread takes at a time
constexpr int kWhiteStride = 3;  // pixels and rows from one that counts for the white to the next
constexpr int kToneSteps = 1 << 14;  // of light: finer than a grey level at the dark end
/// Light, of 1: a picture that is black all over has no white.
constexpr float kLightLeast = 1e-12f;
/// Weight of a saturated pixel of the shortest exposure: less than any other that counts.
constexpr double kLastWeight = 1e-6;
/// Of the exposures' ratio: quantiles compared, and the fewest that are told by grey levels between
/// dark, below which rounding and read noise weigh too much, and saturated.
constexpr int kQuantiles = 400, kFewest = 4;
constexpr double kDark = 8.0;

[[noreturn]] void refuse(const std::string& message) { throw std::invalid_argument(message); }

void checkBracket(const std::vector<Exposure>& bracket) {
  if (bracket.empty()) refuse("the exposure bracket is empty; it must have at least one image");
  for (std::size_t i = 0; i < bracket.size(); ++i) {
    const cv::Mat& image = bracket[i].image;
    const std::string name = "exposure " + std::to_string(i + 1);
    if (image.empty()) refuse(name + " has no image");
    if (image.type() != CV_8UC1 && image.type() != CV_16UC1)
      refuse(name + " must have one channel of 8 or 16 bit");
    if (image.type() != bracket[0].image.type() || image.size() != bracket[0].image.size())
      refuse(name + " has another size or depth than the first");
    if (!(bracket[i].seconds > 0.0 && std::isfinite(bracket[i].seconds)))
      refuse(name + ": its time is " + std::to_string(bracket[i].seconds) +
             " s, must be greater than 0");
  }
}

/// The highest level that the camera gives.
int fullScale(const std::vector<cv::Mat>& images) {
  int bits = 8;
  for (const cv::Mat& image : images) bits = std::max(bits, bitsInUse(image));
  return (1 << bits) - 1;
}

/// Light that a grey level stands for, 0..1.
double linear(const int grey, const int full, const HdrParams& params) {
  const double share = static_cast<double>(grey) / full;
  return std::pow(std::max(0.0, share - params.black_level) / (1.0 - params.black_level),
                  params.response_gamma);
}

/// What one grey level of one exposure adds to the two sums of a pixel.
struct Share {
  float light = 0.0f, seconds = 0.0f;
};

std::vector<Share> shares(const double seconds, const double least_weight, const int full,
                          const HdrParams& params) {
  std::vector<Share> table(full + 1);
  for (int grey = 0; grey <= full; ++grey) {
    const double fade = (params.saturation_to - static_cast<double>(grey) / full) /
                        (params.saturation_to - params.saturation_from);
    const double weight = std::max(least_weight, std::clamp(fade, 0.0, 1.0));
    table[grey].light = static_cast<float>(weight * linear(grey, full, params));
    table[grey].seconds = static_cast<float>(weight * seconds);
  }
  return table;
}

template <class Grey>
cv::Mat_<float> mergeLight(const std::vector<Exposure>& bracket,
                           const std::vector<std::vector<Share>>& tables, int threads) {
  cv::Mat_<float> light(bracket[0].image.size());
  parallelFor((light.rows + kBand - 1) / kBand, threads, [&](int band) {
    std::vector<Share> sums(light.cols);
    for (int y = band * kBand; y < std::min((band + 1) * kBand, light.rows); ++y) {
      std::fill(sums.begin(), sums.end(), Share{});
      for (std::size_t k = 0; k < bracket.size(); ++k) {
        const Grey* grey = bracket[k].image.ptr<Grey>(y);
        const Share* table = tables[k].data();
        for (int x = 0; x < light.cols; ++x) {
          sums[x].light += table[grey[x]].light;
          sums[x].seconds += table[grey[x]].seconds;
        }
      }
      for (int x = 0; x < light.cols; ++x) light(y, x) = sums[x].light / sums[x].seconds;
    }
  });
  return light;
}

/// The light that becomes white.
float whitePoint(const cv::Mat_<float>& light, const double percentile) {
  std::vector<float> values;
  for (int y = 0; y < light.rows; y += kWhiteStride)
    for (int x = 0; x < light.cols; x += kWhiteStride) values.push_back(light(y, x));
  const auto rank =
      static_cast<std::ptrdiff_t>(std::lround(percentile / 100.0 * (values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return std::max(values[rank], kLightLeast);
}

cv::Mat toneMap(const cv::Mat_<float>& light, const HdrParams& params, int threads) {
  const float scale = kToneSteps / whitePoint(light, params.white_percentile);
  std::vector<std::uint8_t> curve(kToneSteps + 1);
  for (int i = 0; i <= kToneSteps; ++i) {
    const double share = static_cast<double>(i) / kToneSteps, c = params.compression;
    curve[i] = static_cast<std::uint8_t>(
        std::lround(255.0 * (c > 0.0 ? std::log1p(c * share) / std::log1p(c) : share)));
  }
  cv::Mat out(light.size(), CV_8U);
  parallelFor((light.rows + kBand - 1) / kBand, threads, [&](int band) {
    for (int y = band * kBand; y < std::min((band + 1) * kBand, light.rows); ++y) {
      auto* const row = out.ptr<std::uint8_t>(y);
      for (int x = 0; x < light.cols; ++x) {
        row[x] =
            curve[static_cast<int>(std::min(light(y, x) * scale, static_cast<float>(kToneSteps)))];
      }
    }
  });
  return out;
}

/// How many pixels lie below each grey level, of 256 levels, from every second pixel and row.
std::vector<double> cumulate(const cv::Mat& image, const int full) {
  std::vector<double> below(257, 0.0);
  const auto count = [&](auto grey) {
    using Grey = decltype(grey);
    for (int y = 0; y < image.rows; y += 2) {
      const Grey* row = image.ptr<Grey>(y);
      for (int x = 0; x < image.cols; x += 2) ++below[1 + row[x] * 255 / full];
    }
  };
  if (image.depth() == CV_8U) {
    count(std::uint8_t{});
  } else {
    count(std::uint16_t{});
  }
  std::partial_sum(below.begin(), below.end(), below.begin());
  return below;
}

/// The grey level, 0..255 with fractions, below which that many pixels lie.
double levelAt(const std::vector<double>& below, const double count) {
  const auto above = std::upper_bound(below.begin() + 1, below.end() - 1, count);
  const double share = (count - *(above - 1)) / std::max(1.0, *above - *(above - 1));
  return static_cast<double>(above - below.begin() - 1) + std::clamp(share, 0.0, 1.0) - 0.5;
}

}  // namespace

void validate(const HdrParams& params) {
  HdrParams::fields(params, [](const char* key, double value, double min, double max) {
    if (value >= min && value <= max) return;
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << key << " is " << value << ", must lie in " << min << " .. " << max;
    refuse(text.str());
  });
  if (!(params.saturation_from < params.saturation_to))
    refuse("saturation_from must be less than saturation_to");
}

cv::Mat mergeExposures(const std::vector<Exposure>& bracket, const HdrParams& params, int threads) {
  validate(params);
  checkBracket(bracket);
  std::vector<Exposure> sorted = bracket;  // sums of floats depend on their order
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Exposure& a, const Exposure& b) { return a.seconds < b.seconds; });
  std::vector<cv::Mat> images;
  for (const Exposure& exposure : sorted) images.push_back(exposure.image);
  const int full = fullScale(images);
  std::vector<std::vector<Share>> tables;
  for (const Exposure& exposure : sorted) {
    // Where even the shortest is saturated, it is all there is to go by.
    tables.push_back(shares(exposure.seconds, tables.empty() ? kLastWeight : 0.0, full, params));
  }
  const cv::Mat_<float> light = images[0].depth() == CV_8U
                                    ? mergeLight<std::uint8_t>(sorted, tables, threads)
                                    : mergeLight<std::uint16_t>(sorted, tables, threads);
  return toneMap(light, params, threads);
}

std::optional<double> exposureRatio(const cv::Mat& reference, const cv::Mat& image,
                                    const HdrParams& params) {
  checkBracket({{reference, 1.0}, {image, 1.0}});
  const int full = fullScale({reference, image});
  const auto below_reference = cumulate(reference, full), below_image = cumulate(image, full);
  const double bright = 255.0 * params.saturation_from, dark = kDark + 255.0 * params.black_level;
  const auto light = [&](double level) {
    return std::pow(level / 255.0 - params.black_level, params.response_gamma);
  };
  std::vector<double> ratios;
  for (int i = 1; i < kQuantiles; ++i) {
    const double count = below_image.back() * i / kQuantiles;
    const double a = levelAt(below_reference, count), b = levelAt(below_image, count);
    if (std::min(a, b) > dark && std::max(a, b) < bright) ratios.push_back(light(b) / light(a));
  }
  if (ratios.size() < kFewest) return std::nullopt;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

}  // namespace planar_bin_picking
