// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/graceful_end.h"

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>

#include <atomic>
#include <csignal>

namespace planar_bin_picking_ros {
namespace {

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

int runGracefully(int argc, char** argv, const std::string& name,
                  const std::function<std::shared_ptr<void>(const ros::NodeHandle& nh,
                                                            const ros::NodeHandle& pnh)>& make) {
  ros::init(argc, argv, name, ros::init_options::NoSigintHandler);
  // Outside the try block: with its last handle ROS shuts down, and its log falls silent.
  const ros::NodeHandle nh, pnh("~");
  handleEnds();
  try {
    const std::shared_ptr<void> node = make(nh, pnh);
    while (!is_to_end && ros::ok()) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
    }
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}

}  // namespace planar_bin_picking_ros
