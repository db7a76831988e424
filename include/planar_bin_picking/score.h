// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace planar_bin_picking {
struct ScoreParams {
  double threshold = 0.8;  ///< detections below are not returned
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("threshold", self.threshold, 0.0, 1.0);
  }
};
}  // namespace planar_bin_picking
