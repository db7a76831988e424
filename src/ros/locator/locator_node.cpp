// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/locator_ros.h"
#include "shared/graceful_end.h"

#include <malloc.h>

#include <algorithm>
#include <thread>

namespace {

/// Many threads serve calls, one or a few at a time. The C library would give each a heap of its
/// own, eight to a core, and keep what every one of them has grown to.
void shareHeaps() {
#ifdef M_ARENA_MAX
  constexpr unsigned int kFewest = 2;
  mallopt(M_ARENA_MAX, static_cast<int>(std::max(kFewest, std::thread::hardware_concurrency())));
#endif
}

}  // namespace

int main(int argc, char** argv) {
  using namespace planar_bin_picking_ros;
  shareHeaps();
  return runGracefully(argc, argv, "locator", [](const auto& nh, const auto& pnh) {
    return std::make_shared<LocatorRos>(nh, pnh);
  });
}
