// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibrator_ros.h"
#include "shared/graceful_end.h"

int main(int argc, char** argv) {
  using namespace planar_bin_picking_ros;
  return runGracefully(argc, argv, "calibrator", [](const auto& nh, const auto& pnh) {
    return std::make_shared<CalibratorRos>(nh, pnh);
  });
}
