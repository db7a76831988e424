// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace planar_bin_picking {
struct HoughParams {
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
  }
};
}  // namespace planar_bin_picking
