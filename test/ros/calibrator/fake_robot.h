// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A robot that answers as a test tells it, and the mover in front of it.

#include "calibrator/robot_mover.h"

#include <gtest/gtest.h>
#include <ros/time.h>

#include <atomic>
#include <thread>
#include <vector>

namespace planar_bin_picking_ros {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// An answer that the test gives.
class FakeCall : public RobotCall {
 public:
  bool waitUntil(Clock::time_point deadline) override {
    std::unique_lock<std::mutex> lock(mutex_);
    return over_.wait_until(lock, deadline, [this] { return is_over_; });
  }
  void breakOff() override {
    is_broken_off = true;
    finish(CallEnd::kFailed, {});
  }
  CallEnd end() const override { return end_; }
  const RobotMover::Response& response() const override { return response_; }

  void finish(CallEnd end, const RobotMover::Response& response) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_over_) return;
    end_ = end;
    response_ = response;
    is_over_ = true;
    over_.notify_all();
  }
  void answer(bool success, bool reachable, const std::string& message = "") {
    RobotMover::Response response;
    response.success = success;
    response.reachable = reachable;
    response.message = message;
    finish(CallEnd::kAnswered, response);
  }

  std::atomic<bool> is_broken_off{false};

 private:
  std::mutex mutex_;
  std::condition_variable over_;
  bool is_over_ = false;
  CallEnd end_ = CallEnd::kFailed;
  RobotMover::Response response_;
};

/// A robot whose answers are rules.
struct FakeRobot : RobotConnection {
  std::function<void(const std::shared_ptr<FakeCall>&)> on_move, on_stop;
  std::mutex mutex;
  std::vector<std::shared_ptr<FakeCall>> moves, stops;
  std::vector<RobotMover::Request> requests;
  int prepared = 0;

  void prepareStop() override { ++prepared; }
  std::string name() const override { return "/robot"; }
  std::shared_ptr<RobotCall> send(const RobotMover::Request& request, bool is_stop) override {
    const auto call = std::make_shared<FakeCall>();
    {
      const std::lock_guard<std::mutex> lock(mutex);
      (is_stop ? stops : moves).push_back(call);
      requests.push_back(request);
    }
    const auto& rule = is_stop ? on_stop : on_move;
    if (rule) rule(call);
    return call;
  }
  std::size_t moveCount() {
    const std::lock_guard<std::mutex> lock(mutex);
    return moves.size();
  }
};

inline void confirm(const std::shared_ptr<FakeCall>& call) { call->answer(true, true); }

class RobotMoverTest : public testing::Test {
 protected:
  RobotMoverTest() {
    ros::Time::init();
    auto robot = std::make_unique<FakeRobot>();
    robot_ = robot.get();
    robot_->on_move = robot_->on_stop = confirm;
    mover_ = std::make_unique<RobotMover>(MoverSettings{"base", 0.3, 0.5, 0.4}, std::move(robot));
  }

  RobotMover::Response move() { return mover_->move(Eigen::Isometry3d::Identity()); }

  std::string failure() {
    try {
      move();
    } catch (const Stopped&) {
      return "stopped";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  /// The move under way ends as a robot ends it that was stopped.
  void endMovesOnStop() {
    robot_->on_move = nullptr;
    robot_->on_stop = [this](const auto& call) {
      for (const auto& m : robot_->moves) m->answer(false, true, "stopped");
      call->answer(true, false);
    };
  }

  void awaitMove() {
    while (robot_->moveCount() == 0) std::this_thread::sleep_for(milliseconds(1));
  }

  FakeRobot* robot_ = nullptr;
  std::unique_ptr<RobotMover> mover_;
};

}  // namespace planar_bin_picking_ros
