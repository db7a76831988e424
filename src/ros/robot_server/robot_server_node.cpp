// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "robot_server/line_server.h"
#include "robot_server/robot_session.h"
#include "shared/graceful_end.h"
#include "shared/param_reader.h"

#include <ros/console.h>

#include <memory>

namespace planar_bin_picking_ros {
namespace {

class RobotServer {
 public:
  RobotServer(const ros::NodeHandle& nh, const ros::NodeHandle& pnh)
      : cell_(readFields<RobotServerParams>(readTree(pnh, "server"), "server"), nh),
        server_(settings(), [this]() -> LineServer::Answer {
          const auto session = std::make_shared<RobotSession>(cell_);
          return [session](const std::string& line) { return session->answer(line); };
        }) {
    ROS_INFO_STREAM("server:" << printFields(cell_.params));
    ROS_INFO_STREAM("ready: robot controllers connect to " << cell_.params.address << ":"
                                                           << server_.port());
  }

 private:
  LineServer::Settings settings() const {
    using planar_bin_picking::RobotCode;
    using planar_bin_picking::textLine;
    return {cell_.params.address, cell_.params.port, cell_.params.clients_max,
            textLine(RobotCode::kAgain, "too many clients are connected", cell_.convention,
                     cell_.numbersInLine()),
            textLine(RobotCode::kBadLine, "the line is too long", cell_.convention,
                     cell_.numbersInLine())};
  }

  RobotCell cell_;
  LineServer server_;
};

}  // namespace
}  // namespace planar_bin_picking_ros

int main(int argc, char** argv) {
  using namespace planar_bin_picking_ros;
  return runGracefully(argc, argv, "robot_server", [](const auto& nh, const auto& pnh) {
    return std::make_shared<RobotServer>(nh, pnh);
  });
}
