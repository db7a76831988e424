// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/graceful_end.h"
#include "teach/teach_ros.h"

int main(int argc, char** argv) {
  using namespace planar_bin_picking_ros;
  return runGracefully(argc, argv, "teach", [](const auto& nh, const auto& pnh) {
    return std::make_shared<TeachRos>(nh, pnh);
  });
}
