// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/robot_mover.h"

#include "shared/convert.h"
#include "shared/names.h"

#include <ros/console.h>

#include <algorithm>
#include <thread>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::MoveRobot;

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook(20);  // how often a move that is waited for is looked at
/// After a confirmed stop the move's own answer is on its way; later than this, the stop may have
/// overtaken the move, and is sent again.
constexpr std::chrono::milliseconds kMoveEnds(200);
constexpr std::chrono::milliseconds kAgain(50);  // between stops that are not confirmed

Clock::duration seconds(const double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
}

class RosRobotCall : public RobotCall {
 public:
  RosRobotCall(const std::string& service, const RobotMover::Request& request,
               const ros::ServiceServerLinkPtr& link)
      : call_(service, request, link) {}
  bool waitUntil(Clock::time_point deadline) override { return call_.waitUntil(deadline); }
  void breakOff() override { call_.breakOff(); }
  CallEnd end() const override { return call_.end(); }
  const RobotMover::Response& response() const override { return call_.response(); }

 private:
  ServiceCall<MoveRobot> call_;
};

/// The stop has a connection that stands before a move begins: it then needs neither the ROS master
/// nor time.
class RosRobotConnection : public RobotConnection {
 public:
  explicit RosRobotConnection(const std::string& service) : service_(service) {}
  ~RosRobotConnection() override { dropService(stop_link_); }

  void prepareStop() override {
    if (stopLink()) return;
    const ros::ServiceServerLinkPtr link = connectService<MoveRobot>(service_);
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_link_ = link;
  }

  std::shared_ptr<RobotCall> send(const RobotMover::Request& request, bool is_stop) override {
    return std::make_shared<RosRobotCall>(service_, request, is_stop ? stopLink() : nullptr);
  }

  std::string name() const override { return service_; }

 private:
  ros::ServiceServerLinkPtr stopLink() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return stop_link_ && stop_link_->isValid() ? stop_link_ : nullptr;
  }

  const std::string service_;
  mutable std::mutex mutex_;
  ros::ServiceServerLinkPtr stop_link_;
};

}  // namespace

RobotMover::RobotMover(const ros::NodeHandle& nh, const MoverSettings& settings)
    : RobotMover(settings,
                 std::make_unique<RosRobotConnection>(nh.resolveName(kMoveRobotService))) {}

RobotMover::RobotMover(const MoverSettings& settings, std::unique_ptr<RobotConnection> robot)
    : settings_(settings), robot_(std::move(robot)) {}

void RobotMover::reset(const bool may_move) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return stop_ != Stop::kUnderWay; });
  may_move_ = may_move;
  is_asked_to_stop_ = false;
  has_moved_ = false;
  go_ = Go::kNotAwaited;
  stop_ = Stop::kNone;
}

void RobotMover::forbidMoves() {
  const std::lock_guard<std::mutex> lock(mutex_);
  may_move_ = false;
  is_asked_to_stop_ = true;
  changed_.notify_all();
}

void RobotMover::throwIfAsked() const {
  if (is_asked_to_stop_) throw Stopped("stopped");
}

bool RobotMover::isAskedToStop() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return is_asked_to_stop_;
}

void RobotMover::checkStop() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  throwIfAsked();
}

void RobotMover::pause(const double duration) const {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(lock, seconds(duration), [this] { return is_asked_to_stop_; });
  throwIfAsked();
}

void RobotMover::awaitGo(const std::function<void()>& announce) {
  std::unique_lock<std::mutex> lock(mutex_);
  go_ = Go::kAwaited;
  lock.unlock();
  announce();
  lock.lock();
  changed_.wait(lock, [this] { return is_asked_to_stop_ || go_ == Go::kGiven; });
  go_ = Go::kNotAwaited;
  throwIfAsked();
}

bool RobotMover::go() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (go_ != Go::kAwaited) return false;
  go_ = Go::kGiven;
  changed_.notify_all();
  return true;
}

std::string RobotMover::stopForReason() {
  return stopNow() ? "; it was told to stop, and confirmed it"
                   : "; it was told to stop, and the stop was not confirmed: use the robot's own "
                     "stop";
}

void RobotMover::fail(const std::string& reason) {
  throw std::runtime_error(reason + stopForReason());
}

std::string RobotMover::stopAfterFailure() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!has_moved_ || stop_ != Stop::kNone) return "";
  }
  return stopForReason();
}

std::shared_ptr<RobotCall> RobotMover::begin(const Eigen::Isometry3d& T_base_flange) {
  Request request;
  request.target.header.frame_id = settings_.base_frame;
  request.target.header.stamp = ros::Time::now();
  request.target.pose = toPoseMsg(T_base_flange);
  request.speed_scale = settings_.speed_scale;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!may_move_) throw Stopped("stopped");
  }
  robot_->prepareStop();
  // Under the lock: a stop comes before this, and nothing is sent, or after it, and finds the move.
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!may_move_) throw Stopped("stopped");
  has_moved_ = true;
  under_way_ = robot_->send(request, false);
  return under_way_;
}

void RobotMover::awaitEnd(RobotCall* call) {
  const auto deadline = Clock::now() + seconds(settings_.move_timeout);
  while (!call->waitUntil(std::min(deadline, Clock::now() + kLook))) {
    checkStop();
    if (Clock::now() >= deadline) fail("the robot did not answer within move_timeout");
  }
  checkStop();
}

RobotMover::Response RobotMover::move(const Eigen::Isometry3d& T_base_flange) {
  const std::shared_ptr<RobotCall> call = begin(T_base_flange);
  awaitEnd(call.get());
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    under_way_.reset();
  }
  if (call->end() == CallEnd::kNobody) {
    throw std::runtime_error("nobody provides " + robot_->name() +
                             "; start the robot's adapter, or remap move_robot");
  }
  if (call->end() != CallEnd::kAnswered) fail(robot_->name() + " broke off; see the robot's log");
  const Response& answer = call->response();
  if (!answer.success && answer.reachable) {
    fail("the robot broke the move off, as in a protective stop: " +
         (answer.message.empty() ? "it does not say why" : answer.message));
  }
  return answer;
}

bool RobotMover::stopNow() {
  std::unique_lock<std::mutex> lock(mutex_);
  may_move_ = false;
  if (stop_ == Stop::kUnderWay) {
    changed_.wait(lock, [this] { return stop_ != Stop::kUnderWay; });
    return stop_ == Stop::kConfirmed;
  }
  stop_ = Stop::kUnderWay;
  const std::shared_ptr<RobotCall> move = under_way_;
  lock.unlock();
  bool is_confirmed = false;
  try {
    is_confirmed = stopWithin(move.get());
  } catch (const std::exception& error) {  // no thread to be had: whoever waits must be told
    ROS_FATAL_STREAM("the robot cannot be told to stop: " << error.what());
  }
  lock.lock();
  stop_ = is_confirmed ? Stop::kConfirmed : Stop::kNotConfirmed;
  under_way_.reset();
  changed_.notify_all();
  return is_confirmed;
}

bool RobotMover::stopWithin(RobotCall* move) {
  Request request;
  request.target.header.frame_id = settings_.base_frame;
  request.target.pose.orientation.w = 1.0;
  request.speed_scale = 0.0;
  const auto deadline = Clock::now() + seconds(settings_.stop_timeout);
  do {
    const std::shared_ptr<RobotCall> stop = robot_->send(request, true);
    if (stop->waitUntil(deadline) && stop->end() == CallEnd::kAnswered &&
        stop->response().success) {
      if (move == nullptr || move->waitUntil(std::min(deadline, Clock::now() + kMoveEnds))) {
        return true;
      }
    } else {
      std::this_thread::sleep_for(kAgain);
    }
  } while (Clock::now() < deadline);
  // Should its request still wait to be sent, it never is.
  if (move != nullptr) move->breakOff();
  return false;
}

bool RobotMover::isStopConfirmed() {
  {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return stop_ != Stop::kUnderWay; });
    if (stop_ != Stop::kNone) return stop_ == Stop::kConfirmed;
  }
  return stopNow();
}

}  // namespace planar_bin_picking_ros
