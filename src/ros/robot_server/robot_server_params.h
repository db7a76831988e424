// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the robot server is told, below `~server`; see config/robot_server.yaml. The defaults stand
/// here and nowhere else.

#include <string>
#include <vector>

namespace planar_bin_picking_ros {

struct RobotServerParams {
  std::string address = "127.0.0.1";  ///< only programs on this machine can connect
  int port = 5700;
  int clients_max = 4;
  std::string convention = "plain";  ///< see planar_bin_picking/robot/orientation.h
  std::string locator = "locator";   ///< name of its node
  double timeout = 20.0;             ///< s, wall time, for one call of the locator
  std::vector<double> tool;          ///< of the tool on the flange, in the convention's numbers
  double approach_mm = 0.0;          ///< before the pick pose against its z; 0 = none is sent
  double retreat_mm = 0.0;           ///< above the pick pose afterwards; 0 = none is sent
  bool numbers = false;              ///< those of part and tool are sent
  std::string calibrator = "calibrator";  ///< name of its node
  double calibrator_timeout = 300.0;      ///< s, wall time, for one call of it
  std::string base_frame = "base";        ///< of the flange's pose that comes with a line
  std::string flange_frame;               ///< "" = tf has the robot's pose

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("address", self.address);
    visit("port", self.port, 0, 65535);
    visit("clients_max", self.clients_max, 1, 100);
    visit("convention", self.convention);
    visit("locator", self.locator);
    visit("timeout", self.timeout, 0.1, 3600.0);
    visit("tool", self.tool);
    visit("approach_mm", self.approach_mm, 0.0, 10000.0);
    visit("retreat_mm", self.retreat_mm, 0.0, 10000.0);
    visit("numbers", self.numbers, false, true);
    visit("calibrator", self.calibrator);
    visit("calibrator_timeout", self.calibrator_timeout, 0.1, 3600.0);
    visit("base_frame", self.base_frame);
    visit("flange_frame", self.flange_frame);
  }
};

}  // namespace planar_bin_picking_ros
