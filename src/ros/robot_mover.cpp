// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "robot_mover.h"

#include "convert.h"
#include "names.h"

#include <ros/service.h>

#include <chrono>
#include <future>
#include <memory>
#include <stdexcept>
#include <thread>

namespace planar_bin_picking_ros {

using planar_bin_picking::MoveRobot;

RobotMover::RobotMover(const ros::NodeHandle& nh, const std::string& base_frame, double speed_scale,
                       double timeout)
    : service_(nh.resolveName(kMoveRobotService)),
      base_frame_(base_frame),
      speed_scale_(speed_scale),
      timeout_(timeout) {}

MoveRobot::Response RobotMover::move(const Eigen::Isometry3d& T_base_flange,
                                     const std::atomic<bool>& stop) {
  if (!ros::service::exists(service_, false)) {
    throw std::runtime_error("nobody provides " + service_ +
                             "; start the robot's adapter, or remap move_robot");
  }
  MoveRobot call;
  call.request.target.header.frame_id = base_frame_;
  call.request.target.header.stamp = ros::Time::now();
  call.request.target.pose = toPoseMsg(T_base_flange);
  call.request.speed_scale = speed_scale_;
  // ROS's call has no time-out: it waits in a thread that may outlive this function.
  struct Answer {
    bool arrived = false;
    MoveRobot::Response response;
  };
  auto promise = std::make_shared<std::promise<Answer>>();
  std::future<Answer> answer = promise->get_future();
  std::thread([promise, call, service = service_]() mutable {
    const bool arrived = ros::service::call(service, call);
    promise->set_value({arrived, call.response});
  }).detach();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_);
  while (answer.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
    if (stop) throw std::runtime_error("stopped while the robot was moving");
    if (std::chrono::steady_clock::now() < deadline) continue;
    stopNow();
    throw std::runtime_error("the robot did not answer within move_timeout and was told to stop");
  }
  const Answer result = answer.get();
  if (stop) throw std::runtime_error("stopped while the robot was moving");
  if (!result.arrived) throw std::runtime_error(service_ + " broke off; see the robot's log");
  return result.response;
}

bool RobotMover::stopNow() {
  MoveRobot call;
  call.request.speed_scale = 0.0;
  return ros::service::call(service_, call);
}

}  // namespace planar_bin_picking_ros
