// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "texture.h"

#include "parallel.h"
#include "scharr.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace planar_bin_picking {
namespace {

/// Mean of Scharr's response over the pixels of every second row.
float meanGradient(const cv::Mat& grey, const cv::Rect& block) {
  float sum = 0.0f;
  int count = 0;
  const int x0 = std::max(1, block.x), x1 = std::min(grey.cols - 1, block.x + block.width);
  for (int y = std::max(1, block.y); y < std::min(grey.rows - 1, block.y + block.height); y += 2) {
    const auto *a = grey.ptr<std::uint8_t>(y - 1), *b = grey.ptr<std::uint8_t>(y),
               *c = grey.ptr<std::uint8_t>(y + 1);
    for (int x = x0; x < x1; ++x) {
      sum += std::sqrt(static_cast<float>(Scharr(a, b, c, x).squared()));
    }
    count += std::max(0, x1 - x0);
  }
  return count > 0 ? sum / static_cast<float>(count) : 0.0f;
}

}  // namespace

Texture::Texture(const cv::Mat& grey, int threads) {
  constexpr int kAround = 2;  // blocks to either side
  // Contours fill few of these blocks, texture all; about teeth and holes up to half of them.
  constexpr double kQuantile = 0.35;
  const int rows = std::max(1, grey.rows / kBlock), cols = std::max(1, grey.cols / kBlock);
  cv::Mat_<float> mean(rows, cols);
  parallelFor(rows, threads, [&](int row) {
    for (int col = 0; col < cols; ++col)
      mean(row, col) = meanGradient(grey, {col * kBlock, row * kBlock, kBlock, kBlock});
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
