// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The robot as the calibrator sees it: go there, or stop at once. The client of MoveRobot.
///
/// All moves pass one gate, and a stop closes it under the same lock: once stopNow() has returned
/// no request to move is sent any more, whatever other threads were about to do. The gate opens
/// for a new run alone.

#include "shared/service_call.h"

#include <planar_bin_picking/MoveRobot.h>
#include <ros/node_handle.h>

#include <Eigen/Geometry>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>

namespace planar_bin_picking_ros {

/// Somebody asked for a stop: ~abort, or the node ends.
class Stopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One request to the robot that is under way.
class RobotCall {
 public:
  virtual ~RobotCall() = default;
  /// @return  whether the call is over
  virtual bool waitUntil(std::chrono::steady_clock::time_point deadline) = 0;
  /// Nothing is sent afterwards.
  virtual void breakOff() = 0;
  virtual CallEnd end() const = 0;
  virtual const planar_bin_picking::MoveRobot::Response& response() const = 0;
};

/// How requests reach the robot.
class RobotConnection {
 public:
  virtual ~RobotConnection() = default;
  /// Called before each move, so that a stop needs no time to find its way.
  virtual void prepareStop() = 0;
  /// Returns at once. A stop goes over a connection of its own.
  virtual std::shared_ptr<RobotCall> send(const planar_bin_picking::MoveRobot::Request& request,
                                          bool is_stop) = 0;
  virtual std::string name() const = 0;  ///< for messages
};

struct MoverSettings {
  std::string base_frame;
  double speed_scale = 0.2;
  double move_timeout = 60.0, stop_timeout = 3.0;  ///< s, wall time
};

class RobotMover {
 public:
  using Request = planar_bin_picking::MoveRobot::Request;
  using Response = planar_bin_picking::MoveRobot::Response;

  /// @param nh  the service's name is resolved in it
  RobotMover(const ros::NodeHandle& nh, const MoverSettings& settings);
  RobotMover(const MoverSettings& settings, std::unique_ptr<RobotConnection> robot);

  /// Something new begins, which no former stop concerns. Waits for a stop that is under way.
  /// @param may_move  opens the gate: for a run alone
  void reset(bool may_move);

  /// Blocks until the robot has answered. Whatever else comes of a move than standing at its end
  /// or "not reachable" ends the run: the robot is told to stop.
  /// @return  success, or neither success nor reachable
  /// @throws Stopped  the gate is closed, or was closed while the robot moved
  /// @throws std::runtime_error  no such service, no answer in time, the motion broke off
  Response move(const Eigen::Isometry3d& T_base_flange);

  /// Closes the gate because somebody asks for it; sends nothing yet. Any thread.
  void forbidMoves();

  /// Closes the gate and tells the robot to stop where it is, beside a move that is under way. A
  /// robot is taken for stopped once it has confirmed it and its move has ended, too: a stop that
  /// overtakes the move on its way would stop nothing. Asks again until stop_timeout. Any thread.
  /// @return  whether it stopped
  bool stopNow();

  /// What came of the stop that somebody asked for; waits for it, or does it.
  bool isStopConfirmed();

  bool isAskedToStop() const;

  /// @throws Stopped  somebody asked for a stop
  void checkStop() const;

  /// Waits. @throws Stopped  at once when somebody asks for a stop
  void pause(double seconds) const;

  /// Waits, as long as it takes, until somebody says go().
  /// @param announce  called once go() is listened to
  /// @throws Stopped  as pause()
  void awaitGo(const std::function<void()>& announce);
  /// @return  false where nobody waits for it
  bool go();

  /// What becomes of a run that failed: the robot is told to stop, unless it never moved or a
  /// failed move has told it already. @return  what came of it, to be added to the reason
  std::string stopAfterFailure();

 private:
  using Clock = std::chrono::steady_clock;
  enum class Stop { kNone, kUnderWay, kConfirmed, kNotConfirmed };

  void throwIfAsked() const;  // mutex_ is held
  std::shared_ptr<RobotCall> begin(const Eigen::Isometry3d& T_base_flange);
  void awaitEnd(RobotCall* call);
  bool stopWithin(RobotCall* move);
  std::string stopForReason();
  [[noreturn]] void fail(const std::string& reason);

  const MoverSettings settings_;
  const std::unique_ptr<RobotConnection> robot_;
  mutable std::mutex mutex_;  // of all below
  mutable std::condition_variable changed_;
  bool may_move_ = false, is_asked_to_stop_ = false, has_moved_ = false;
  enum class Go { kNotAwaited, kAwaited, kGiven } go_ = Go::kNotAwaited;
  Stop stop_ = Stop::kNone;
  std::shared_ptr<RobotCall> under_way_;
};

}  // namespace planar_bin_picking_ros
