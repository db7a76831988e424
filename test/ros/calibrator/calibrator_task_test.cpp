// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibrator_task.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace planar_bin_picking_ros {
namespace {

using Kind = CalibratorTask::Kind;

std::string refusalOf(CalibratorTask* task) {
  try {
    task->begin(Kind::kPlan, [] {});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(CalibratorTask, RefusesTheSecondAndSaysWhy) {
  CalibratorTask task;
  EXPECT_EQ(refusalOf(&task), "");
  const std::vector<std::pair<Kind, std::string>> cases{
      {Kind::kRun, "a calibration is under way; ~abort ends it"},
      {Kind::kPlan, "~plan is under way; call again once it has answered"},
      {Kind::kAddSample, "~add_sample is under way; call again once it has answered"},
      {Kind::kFinish, "~finish is under way; call again once it has answered"}};
  for (const auto& [kind, text] : cases) {
    const auto hold = task.begin(kind, [] {});
    EXPECT_EQ(refusalOf(&task), text);
  }
  EXPECT_EQ(refusalOf(&task), "");
}

TEST(CalibratorTask, HoldMovesAndEndsOnce) {
  CalibratorTask task;
  auto first = task.begin(Kind::kRun, [] {});
  auto moved = std::move(first);
  first.release();  // has nothing any more
  EXPECT_NE(refusalOf(&task), "");
  moved.release();
  const auto next = task.begin(Kind::kFinish, [] {});
  moved.release();
  EXPECT_NE(refusalOf(&task), "");
}

TEST(CalibratorTask, PreparationThatFailsHoldsNothing) {
  CalibratorTask task;
  EXPECT_THROW(task.begin(Kind::kRun, [] { throw std::logic_error("no"); }), std::logic_error);
  EXPECT_EQ(refusalOf(&task), "");
}

TEST(CalibratorTask, ActsDuringRunsAlone) {
  CalibratorTask task;
  int acts = 0;
  const auto act = [&acts] { ++acts; };
  EXPECT_FALSE(task.duringRun(act));
  {
    const auto hold = task.begin(Kind::kPlan, [] {});
    EXPECT_FALSE(task.duringRun(act));
  }
  EXPECT_EQ(acts, 0);
  const auto hold = task.begin(Kind::kRun, [] {});
  EXPECT_TRUE(task.duringRun(act));
  EXPECT_EQ(acts, 1);
}

TEST(CalibratorTask, NothingBeginsOnceClosed) {
  CalibratorTask idle, running;
  int acts = 0;
  EXPECT_FALSE(idle.close([&acts] { ++acts; }));
  const auto hold = running.begin(Kind::kRun, [] {});
  EXPECT_TRUE(running.close([&acts] { ++acts; }));
  EXPECT_EQ(acts, 2);
  EXPECT_NE(refusalOf(&idle).find("is ending"), std::string::npos);
}

// What the holder writes needs no lock of its own: a sanitizer for threads sees no race.
TEST(CalibratorTask, OneOwnerAmongManyThreads) {
  CalibratorTask task;
  int owned = 0;  // guarded by the task
  std::atomic<int> began{0}, refused{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < 2000; ++k) {
        try {
          const auto hold = task.begin(Kind::kAddSample, [] {});
          ++owned;
          ++began;
        } catch (const std::runtime_error&) {
          ++refused;
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(owned, began);
  EXPECT_EQ(began + refused, 8000);
  EXPECT_GT(began, 0);
}

}  // namespace
}  // namespace planar_bin_picking_ros
