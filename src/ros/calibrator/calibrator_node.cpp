// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibrator_ros.h"

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>

#include <atomic>
#include <csignal>

namespace {

// ROS's own handlers tear the connections down at once, and the robot could not be told to stop:
// whoever asks the node to end sets this flag, and ROS is shut down after the calibrator has ended.
std::atomic<bool> is_to_end{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may set it");

void endOnSignal(int) { is_to_end = true; }

/// `rosnode kill`, or another node that takes this one's name.
void endOnRequest(XmlRpc::XmlRpcValue&, XmlRpc::XmlRpcValue& result) {
  is_to_end = true;
  result = ros::xmlrpc::responseInt(1, "", 0);
}

void handleEnds() {
  struct sigaction action {};
  action.sa_handler = endOnSignal;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  ros::XMLRPCManager::instance()->unbind("shutdown");
  ros::XMLRPCManager::instance()->bind("shutdown", endOnRequest);
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "calibrator", ros::init_options::NoSigintHandler);
  // Outside the try block: with its last handle ROS shuts down, and its log falls silent.
  const ros::NodeHandle nh, pnh("~");
  handleEnds();
  try {
    planar_bin_picking_ros::CalibratorRos calibrator(nh, pnh);
    while (!is_to_end && ros::ok()) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
    }
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
