// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

namespace planar_bin_picking {

/// Of an even number the upper middle one, of none 0.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
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
