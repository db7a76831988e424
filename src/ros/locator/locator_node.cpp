// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/locator_ros.h"
#include "shared/graceful_end.h"

int main(int argc, char** argv) {
  using namespace planar_bin_picking_ros;
  return runGracefully(argc, argv, "locator", [](const auto& nh, const auto& pnh) {
    return std::make_shared<LocatorRos>(nh, pnh);
  });
}
