// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How often what is answered with a score is right: the reliability diagram, as a table.

#include <cstdio>
#include <utility>
#include <vector>

namespace planar_bin_picking {

/// One line to each range of scores in which anything was answered.
/// @param scores  score, and whether the pose was right
inline void printReliability(const std::vector<std::pair<double, bool>>& scores) {
  constexpr double kFrom[] = {0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98};
  std::printf("\n| score | answered | its mean | right |\n|---|---|---|---|\n");
  for (std::size_t i = 0; i < std::size(kFrom); ++i) {
    const double from = kFrom[i], to = i + 1 < std::size(kFrom) ? kFrom[i + 1] : 1.01;
    int answered = 0, right = 0;
    double sum = 0.0;
    for (const auto& [score, correct] : scores) {
      if (score < from || score >= to) continue;
      ++answered;
      sum += score;
      right += correct;
    }
    if (answered == 0) continue;
    std::printf("| %.2f to %.2f | %d | %.2f | %.2f |\n", from, to > 1.0 ? 1.0 : to, answered,
                sum / answered, static_cast<double>(right) / answered);
  }
}

}  // namespace planar_bin_picking
