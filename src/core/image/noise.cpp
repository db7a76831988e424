// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/noise.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace planar_bin_picking {
namespace {

constexpr int kLevels = 16;         // of brightness: noise follows it slowly
constexpr int kBlock = 8;           // pixels to a side, so that edges fill few blocks
constexpr int kFewBlocks = 20;      // fewer do not determine a level's median to some ten per cent
constexpr int kMaxDifference = 64;  // grey levels: larger second differences are edges
constexpr int kSteps = 4;           // of a block's median, per grey level
/// Median |second difference| of Gaussian noise of sigma 1: 0.6745 sqrt(1^2 + 2^2 + 1^2).
constexpr float kToSigma = 1.0f / (0.6745f * 2.449f);
/// Grey levels, of that median: rounding to whole levels hides less.
constexpr float kFinest = 0.3f;

}  // namespace

std::array<float, 256> estimateNoise(const cv::Mat& grey) {
  std::array<std::array<int, kMaxDifference * kSteps>, kLevels> counts{};  // by median
  std::array<int, kLevels> blocks{};
  for (int y = 0; y + kBlock <= grey.rows; y += kBlock) {
    for (int x = 0; x + kBlock + 2 <= grey.cols; x += kBlock) {
      std::array<int, kMaxDifference> inside{};
      int sum = 0;
      for (int j = 0; j < kBlock; j += 2) {
        const auto* p = grey.ptr<std::uint8_t>(y + j) + x + 1;
        for (int i = 0; i < kBlock; ++i) {
          ++inside[std::min(std::abs(2 * p[i] - p[i - 1] - p[i + 1]), kMaxDifference - 1)];
          sum += p[i];
        }
      }
      constexpr int kCount = kBlock * kBlock / 2;
      int below = 0, d = 0;
      while (below + inside[d] < kCount / 2) below += inside[d++];
      // Interpolated inside the integer step: fine noise is a fraction of a grey level.
      const int step = kSteps * d + kSteps * (kCount / 2 - below) / inside[d];
      const int level = sum / kCount * kLevels / 256;
      ++counts[level][std::min(step, kSteps * kMaxDifference - 1)];
      ++blocks[level];
    }
  }
  std::array<float, kLevels> sigma{};
  int known = -1;
  for (int level = 0; level < kLevels; ++level) {
    if (blocks[level] < kFewBlocks) continue;
    int below = 0, q = 0;
    while (below + counts[level][q] < (blocks[level] + 1) / 2) below += counts[level][q++];
    sigma[level] = std::max(q / (1.0f * kSteps) - 0.5f, kFinest) * kToSigma;
    // Levels that only edges have: between their neighbours.
    for (int k = known + 1; k < level; ++k) {
      sigma[k] = known < 0
                     ? sigma[level]
                     : sigma[known] + (sigma[level] - sigma[known]) * (k - known) / (level - known);
    }
    known = level;
  }
  for (int k = known + 1; k < kLevels; ++k) sigma[k] = known < 0 ? kFinest : sigma[known];
  std::array<float, 256> out{};
  for (int g = 0; g < 256; ++g) {
    const float at = std::clamp(g * kLevels / 256.0f - 0.5f, 0.0f, kLevels - 1.001f);
    const int i = static_cast<int>(at);
    out[g] = sigma[i] + (at - i) * (sigma[i + 1] - sigma[i]);
  }
  return out;
}

}  // namespace planar_bin_picking
