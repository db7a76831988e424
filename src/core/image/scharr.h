// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace planar_bin_picking {

/// Scharr's response at column x of the middle of three rows; a unit ramp answers with 32.
struct Scharr {
  int h, v;

  Scharr(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below, int x)
      : h(3 * (above[x + 1] - above[x - 1] + below[x + 1] - below[x - 1]) +
          10 * (row[x + 1] - row[x - 1])),
        v(3 * (below[x - 1] - above[x - 1] + below[x + 1] - above[x + 1]) +
          10 * (below[x] - above[x])) {}

  int squared() const { return h * h + v * v; }
};

}  // namespace planar_bin_picking
