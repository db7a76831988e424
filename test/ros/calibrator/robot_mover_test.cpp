// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/robot_mover.h"

#include "ros/calibrator/fake_robot.h"

#include <gtest/gtest.h>

namespace planar_bin_picking_ros {
namespace {

TEST_F(RobotMoverTest, MovesOnlyAfterReset) {
  EXPECT_EQ(failure(), "stopped");
  mover_->reset(false);
  EXPECT_EQ(failure(), "stopped");
  EXPECT_TRUE(robot_->moves.empty());
  mover_->reset(true);
  EXPECT_TRUE(move().success);
  EXPECT_EQ(robot_->prepared, 1);
}

TEST_F(RobotMoverTest, AsksForWhatItIsTold) {
  mover_->reset(true);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
  mover_->move(T);
  mover_->stopNow();
  ASSERT_EQ(robot_->requests.size(), 2u);
  const auto& [to, stop] = std::tie(robot_->requests[0], robot_->requests[1]);
  EXPECT_EQ(to.target.header.frame_id, "base");
  EXPECT_FALSE(to.target.header.stamp.isZero());
  EXPECT_DOUBLE_EQ(to.target.pose.position.y, 0.2);
  EXPECT_DOUBLE_EQ(to.target.pose.orientation.w, 1.0);
  EXPECT_DOUBLE_EQ(to.speed_scale, 0.3);
  EXPECT_DOUBLE_EQ(stop.speed_scale, 0.0);
  EXPECT_EQ(stop.target.header.frame_id, "base");
  EXPECT_DOUBLE_EQ(stop.target.pose.orientation.w, 1.0);
}

TEST_F(RobotMoverTest, NothingMovesAfterStop) {
  mover_->reset(true);
  EXPECT_TRUE(move().success);
  EXPECT_TRUE(mover_->stopNow());
  EXPECT_EQ(failure(), "stopped");
  EXPECT_EQ(robot_->moves.size(), 1u);
  EXPECT_FALSE(mover_->isAskedToStop());  // nobody did: it was the mover's own
  EXPECT_NO_THROW(mover_->checkStop());
  mover_->forbidMoves();
  EXPECT_TRUE(mover_->isAskedToStop());
  EXPECT_THROW(mover_->checkStop(), Stopped);
  EXPECT_THROW(mover_->pause(10.0), Stopped);
  mover_->reset(true);
  mover_->forbidMoves();  // the gate is closed before any stop is sent
  EXPECT_EQ(failure(), "stopped");
  EXPECT_EQ(robot_->moves.size(), 1u);
  mover_->reset(true);
  EXPECT_FALSE(mover_->isAskedToStop());
  EXPECT_TRUE(move().success);
}

// Whenever the stop comes, no request to move is sent after it has returned.
TEST_F(RobotMoverTest, NoMoveIsSentAfterStopReturned) {
  for (int round = 0; round < 200; ++round) {
    mover_->reset(true);
    std::thread mover([this] {
      try {
        while (true) move();
      } catch (const Stopped&) {
      }
    });
    std::this_thread::sleep_for(std::chrono::microseconds(7 * round));
    mover_->forbidMoves();
    EXPECT_TRUE(mover_->stopNow());
    const std::size_t count = robot_->moveCount();
    mover.join();
    EXPECT_EQ(robot_->moveCount(), count);
  }
}

TEST_F(RobotMoverTest, StopEndsTheMoveUnderWay) {
  endMovesOnStop();
  mover_->reset(true);
  std::string result;
  std::thread thread([&] { result = failure(); });
  awaitMove();
  mover_->forbidMoves();
  EXPECT_TRUE(mover_->stopNow());
  EXPECT_TRUE(mover_->isStopConfirmed());
  thread.join();
  EXPECT_EQ(result, "stopped");
  EXPECT_EQ(robot_->stops.size(), 1u);
}

// The stop came first, and the robot begins to move only then.
TEST_F(RobotMoverTest, StopIsSentAgainWhereTheMoveRunsOn) {
  robot_->on_move = nullptr;
  robot_->on_stop = [this](const auto& call) {
    if (robot_->stops.size() == 2) robot_->moves[0]->answer(false, true);
    call->answer(true, false);
  };
  mover_->reset(true);
  std::thread thread([&] { EXPECT_EQ(failure(), "stopped"); });
  awaitMove();
  mover_->forbidMoves();
  EXPECT_TRUE(mover_->stopNow());
  thread.join();
  EXPECT_EQ(robot_->stops.size(), 2u);
}

TEST_F(RobotMoverTest, MoveThatNeverEndsIsNotStopped) {
  robot_->on_move = nullptr;
  mover_->reset(true);
  std::thread thread([&] { EXPECT_EQ(failure(), "stopped"); });
  awaitMove();
  mover_->forbidMoves();
  const auto start = Clock::now();
  EXPECT_FALSE(mover_->stopNow());
  EXPECT_GE(Clock::now() - start, milliseconds(390));  // stop_timeout
  EXPECT_LT(Clock::now() - start, milliseconds(1500));
  thread.join();
  EXPECT_FALSE(mover_->isStopConfirmed());
  EXPECT_TRUE(robot_->moves[0]->is_broken_off);
  EXPECT_LE(robot_->stops.size(), 4u);
}

TEST_F(RobotMoverTest, StopThatIsNotConfirmed) {
  const std::vector<std::function<void(const std::shared_ptr<FakeCall>&)>> rules{
      nullptr,  // hangs
      [](const auto& call) { call->answer(false, true, "cannot"); },
      [](const auto& call) { call->finish(CallEnd::kNobody, {}); },
      [](const auto& call) { call->finish(CallEnd::kFailed, {}); },
      [](const auto&) { throw std::runtime_error("no thread"); }};
  for (const auto& rule : rules) {
    mover_->reset(true);
    robot_->stops.clear();
    robot_->on_stop = rule;
    const auto start = Clock::now();
    EXPECT_FALSE(mover_->stopNow());
    EXPECT_FALSE(mover_->isStopConfirmed());
    EXPECT_LT(Clock::now() - start, milliseconds(1500));
    EXPECT_LT(robot_->stops.size(), 12u);
    EXPECT_EQ(failure(), "stopped");
  }
}

// It answers a stop only once it stands.
TEST_F(RobotMoverTest, StopThatTakesTimeIsSentOnce) {
  std::vector<std::thread> threads;
  robot_->on_stop = [&threads](const auto& call) {
    threads.emplace_back([call] {
      std::this_thread::sleep_for(milliseconds(250));
      call->answer(true, false);
    });
  };
  mover_->reset(true);
  EXPECT_TRUE(mover_->stopNow());
  EXPECT_EQ(robot_->stops.size(), 1u);
  for (auto& thread : threads) thread.join();
}

TEST_F(RobotMoverTest, StopsAtOneTimeShareOneOutcome) {
  robot_->on_stop = nullptr;
  mover_->reset(true);
  std::atomic<int> confirmed{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back([&] { confirmed += mover_->stopNow() ? 1 : 0; });
  std::this_thread::sleep_for(milliseconds(100));
  {
    const std::lock_guard<std::mutex> lock(robot_->mutex);
    ASSERT_EQ(robot_->stops.size(), 1u);
    robot_->stops[0]->answer(true, false);
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(confirmed, 4);
}

TEST_F(RobotMoverTest, OutcomeStopsWhereNobodyDidYet) {
  mover_->reset(true);
  mover_->forbidMoves();
  EXPECT_TRUE(mover_->isStopConfirmed());
  EXPECT_EQ(robot_->stops.size(), 1u);
  EXPECT_TRUE(mover_->isStopConfirmed());
  EXPECT_EQ(robot_->stops.size(), 1u);
}

TEST_F(RobotMoverTest, HangingMoveEndsInTime) {
  endMovesOnStop();
  mover_->reset(true);
  const auto start = Clock::now();
  EXPECT_EQ(failure(),
            "the robot did not answer within move_timeout; it was told to stop, and "
            "confirmed it");
  EXPECT_GE(Clock::now() - start, milliseconds(490));
  EXPECT_LT(Clock::now() - start, milliseconds(1500));
  EXPECT_EQ(failure(), "stopped");  // the gate is closed
  EXPECT_EQ(robot_->moves.size(), 1u);
}

TEST_F(RobotMoverTest, ProtectiveStopEndsTheRun) {
  robot_->on_move = [](const auto& call) { call->answer(false, true, "light curtain"); };
  mover_->reset(true);
  const std::string said = failure();
  EXPECT_NE(said.find("light curtain"), std::string::npos) << said;
  EXPECT_NE(said.find("confirmed it"), std::string::npos) << said;
  EXPECT_EQ(robot_->stops.size(), 1u);
  EXPECT_EQ(failure(), "stopped");
  robot_->on_move = [](const auto& call) { call->answer(false, true); };
  robot_->on_stop = nullptr;
  mover_->reset(true);
  const std::string again = failure();
  EXPECT_NE(again.find("does not say why"), std::string::npos) << again;
  EXPECT_NE(again.find("not confirmed"), std::string::npos) << again;
}

TEST_F(RobotMoverTest, UnreachableIsAnAnswer) {
  robot_->on_move = [](const auto& call) { call->answer(false, false); };
  mover_->reset(true);
  EXPECT_FALSE(move().success);
  EXPECT_FALSE(move().success);
  EXPECT_TRUE(robot_->stops.empty());
}

TEST_F(RobotMoverTest, NobodyAndBrokenOff) {
  robot_->on_move = [](const auto& call) { call->finish(CallEnd::kNobody, {}); };
  mover_->reset(true);
  EXPECT_NE(failure().find("nobody provides /robot"), std::string::npos);
  robot_->on_move = [](const auto& call) { call->finish(CallEnd::kFailed, {}); };
  EXPECT_NE(failure().find("/robot broke off"), std::string::npos);
  EXPECT_EQ(robot_->stops.size(), 1u);
}

TEST_F(RobotMoverTest, GoesOnWhenTold) {
  mover_->reset(true);
  EXPECT_FALSE(mover_->go());
  std::atomic<int> announced{0}, gone{0};
  std::thread thread([&] {
    mover_->awaitGo([&] { ++announced; });
    ++gone;
    EXPECT_THROW(mover_->awaitGo([&] { ++announced; }), Stopped);
  });
  while (announced == 0) std::this_thread::sleep_for(milliseconds(1));
  std::this_thread::sleep_for(milliseconds(50));
  EXPECT_EQ(gone, 0);
  EXPECT_TRUE(mover_->go());
  while (announced == 1) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(gone, 1);  // and asks again
  mover_->forbidMoves();
  thread.join();
  EXPECT_FALSE(mover_->go());
  EXPECT_EQ(announced, 2);
}

// Told from where it is announced, it is not lost.
TEST_F(RobotMoverTest, ListensOnceItHasAnnounced) {
  mover_->reset(true);
  mover_->awaitGo([this] { EXPECT_TRUE(mover_->go()); });
  EXPECT_FALSE(mover_->go());
}

TEST_F(RobotMoverTest, FailureStopsARobotThatMoved) {
  mover_->reset(true);
  EXPECT_EQ(mover_->stopAfterFailure(), "");
  EXPECT_TRUE(robot_->stops.empty());
  move();
  EXPECT_EQ(mover_->stopAfterFailure(), "; it was told to stop, and confirmed it");
  EXPECT_EQ(robot_->stops.size(), 1u);
  EXPECT_EQ(mover_->stopAfterFailure(), "");  // it was told already
  EXPECT_EQ(robot_->stops.size(), 1u);
  EXPECT_EQ(failure(), "stopped");
  mover_->reset(true);
  EXPECT_EQ(mover_->stopAfterFailure(), "");
  robot_->on_stop = nullptr;
  move();
  EXPECT_NE(mover_->stopAfterFailure().find("not confirmed"), std::string::npos);
}

TEST_F(RobotMoverTest, PauseEndsAtOnce) {
  mover_->reset(true);
  auto start = Clock::now();
  mover_->pause(0.1);
  EXPECT_GE(Clock::now() - start, milliseconds(95));
  std::thread thread([this] {
    std::this_thread::sleep_for(milliseconds(50));
    mover_->forbidMoves();
  });
  start = Clock::now();
  EXPECT_THROW(mover_->pause(20.0), Stopped);
  EXPECT_LT(Clock::now() - start, milliseconds(5000));
  thread.join();
}

}  // namespace
}  // namespace planar_bin_picking_ros
