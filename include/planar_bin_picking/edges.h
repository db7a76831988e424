// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace planar_bin_picking {
struct EdgesParams {
  double noise_factor = 4.0;  ///< an edgel's gradient is at least this many times the image's noise
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("noise_factor", self.noise_factor, 1.0, 50.0);
  }
};
}  // namespace planar_bin_picking
