// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/texture.h"

#include "base/parallel.h"
#include "base/simd.h"
#include "image/scharr.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr int kAround = 2;   // blocks to either side that a level is taken from
constexpr int kRowStep = 2;  // every second row of the image will do
/// Contours fill few of these blocks, texture all; about teeth and holes up to half of them.
constexpr double kQuantile = 0.35;
constexpr int kSide = 2 * kAround + 1, kNear = kSide * kSide;  // blocks that a level is taken from

}  // namespace

/// Adds the strength of Scharr's response at columns 1 to w - 2 of the middle of three rows.
PBP_SIMD
static void addStrengths(const std::uint8_t* above, const std::uint8_t* row,
                         const std::uint8_t* below, int w, float* sums) {
  for (int x = 1; x < w - 1; ++x)
    sums[x] += std::sqrt(static_cast<float>(Scharr(above, row, below, x).squared()));
}

/// The quantile of the blocks about kFloatsOfVector blocks side by side, none of which is near the
/// border.
/// @param first  of the blocks about the first of them; `pitch` to the next row
PBP_SIMD
static void quantiles(const float* first, std::size_t pitch, float* out) {
  constexpr int kKept = static_cast<int>(kQuantile * kNear) + 1;
  FloatVector least[kKept];  // sorted, of the values so far
  for (FloatVector& l : least) l = FloatVector{} + std::numeric_limits<float>::max();
  for (int y = 0; y < kSide; ++y, first += pitch) {
    for (int x = 0; x < kSide; ++x) {
      FloatVector v;
      load(first + x, &v);
      for (FloatVector& l : least) {
        const FloatVector lower = v < l ? v : l;
        v = v < l ? l : v;
        l = lower;
      }
    }
  }
  std::memcpy(out, &least[kKept - 1], sizeof least[0]);
}

/// The same for one block anywhere.
static float quantileAt(const cv::Mat_<float>& mean, int row, int col) {
  std::array<float, kNear> near{};
  int n = 0;
  for (int y = std::max(0, row - kAround); y <= std::min(mean.rows - 1, row + kAround); ++y)
    for (int x = std::max(0, col - kAround); x <= std::min(mean.cols - 1, col + kAround); ++x)
      near[n++] = mean(y, x);
  const auto middle = near.begin() + static_cast<int>(kQuantile * n);
  std::nth_element(near.begin(), middle, near.begin() + n);
  return *middle;
}

static void setLevels(const cv::Mat_<float>& mean, int row, cv::Mat_<float>* level) {
  const bool is_inner = row >= kAround && row + kAround < mean.rows;
  for (int col = 0; col < mean.cols;) {
    if (is_inner && col >= kAround && col + kFloatsOfVector + kAround <= mean.cols) {
      quantiles(&mean(row - kAround, col - kAround), mean.step1(), &(*level)(row, col));
      col += kFloatsOfVector;
    } else {
      (*level)(row, col) = quantileAt(mean, row, col);
      ++col;
    }
  }
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
  parallelFor(rows, threads, [&](int row) { setLevels(mean, row, &level_); });
}

}  // namespace planar_bin_picking
