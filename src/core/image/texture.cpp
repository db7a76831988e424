// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/texture.h"

#include "base/parallel.h"
#include "base/simd.h"
#include "image/scharr.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr int kAround = 2;   // blocks to either side that a level is taken from
constexpr int kRowStep = 2;  // every second row of the image will do
/// Contours fill few of these blocks, texture all; about teeth and holes up to half of them.
constexpr double kQuantile = 0.35;

}  // namespace

/// Adds the strength of Scharr's response at columns 1 to w - 2 of the middle of three rows.
PBP_SIMD
static void addStrengths(const std::uint8_t* above, const std::uint8_t* row,
                         const std::uint8_t* below, int w, float* sums) {
  for (int x = 1; x < w - 1; ++x)
    sums[x] += std::sqrt(static_cast<float>(Scharr(above, row, below, x).squared()));
}

Texture::Texture(const cv::Mat& grey, int threads) {
  const int rows = std::max(1, grey.rows / kBlock), cols = std::max(1, grey.cols / kBlock);
  cv::Mat_<float> mean(rows, cols, 0.0f);
  parallelFor(rows, threads, [&](int row) {
    std::vector<float> sums(static_cast<std::size_t>(grey.cols), 0.0f);  // by column
    for (int k = 0; k < kBlock; k += kRowStep) {
      const int y = std::max(1, row * kBlock + k);
      if (y + 1 >= grey.rows) break;
      addStrengths(grey.ptr(y - 1), grey.ptr(y), grey.ptr(y + 1), grey.cols, sums.data());
    }
    for (int col = 0; col < cols; ++col) {
      const auto block = sums.begin() + col * kBlock;
      const auto end = block + std::min(kBlock, grey.cols - col * kBlock);
      mean(row, col) = std::accumulate(block, end, 0.0f) / (kBlock * kBlock / kRowStep);
    }
  });
  level_.create(rows, cols);
  parallelFor(rows, threads, [&](int row) {
    std::array<float, (2 * kAround + 1) * (2 * kAround + 1)> near{};
    for (int col = 0; col < cols; ++col) {
      int n = 0;
      for (int y = std::max(0, row - kAround); y <= std::min(rows - 1, row + kAround); ++y)
        for (int x = std::max(0, col - kAround); x <= std::min(cols - 1, col + kAround); ++x)
          near[n++] = mean(y, x);
      const auto middle = near.begin() + static_cast<int>(kQuantile * n);
      std::nth_element(near.begin(), middle, near.begin() + n);
      level_(row, col) = *middle;
    }
  });
}

}  // namespace planar_bin_picking
