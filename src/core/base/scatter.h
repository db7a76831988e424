// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace planar_bin_picking {

/// Of an even number the upper middle one, of none 0.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// The value at which half of the weight lies below and half above; of none 0.
/// @param weights  as many as values, not negative
inline double weightedMedian(const std::vector<double>& values,
                             const std::vector<double>& weights) {
  std::vector<std::pair<double, double>> sorted;
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sorted.emplace_back(values[i], weights[i]);
    sum += weights[i];
  }
  std::sort(sorted.begin(), sorted.end());
  double below = 0.0;
  for (const auto& [value, weight] : sorted) {
    below += weight;
    if (below > 0.5 * sum) return value;
  }
  return sorted.empty() ? 0.0 : sorted.back().first;
}

/// Variance over median of a Gaussian's square, and of the sum of two such squares.
inline constexpr double kVarianceOfOne = 2.198, kVarianceOfTwo = 0.721;

/// Variance of true values from their measured ones, robust: what these scatter beyond their
/// errors.
/// @param squares      of the measured values about their middle
/// @param to_variance  kVarianceOfOne or kVarianceOfTwo
/// @param variances    of the measurements
inline double scatterBeyond(const std::vector<double>& squares, double to_variance,
                            const std::vector<double>& variances, double least_sigma) {
  return std::max(least_sigma * least_sigma, to_variance * median(squares) - median(variances));
}

}  // namespace planar_bin_picking
