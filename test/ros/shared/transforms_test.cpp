// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/transforms.h"

#include "shared/clock_watch.h"
#include "shared/convert.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::isometryNear;
using std::chrono::duration;
using std::chrono::steady_clock;

const duration<double> kNoWait(0.0);

void set(TransformBuffer& buffer, const double time, const double x,
         const std::string& parent = "base", const std::string& child = "camera",
         const bool is_static = false) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.header.stamp = ros::Time(time);
  message.child_frame_id = child;
  message.transform = toTransformMsg(Eigen::Isometry3d(Eigen::Translation3d(x, 0.0, 1.0)));
  buffer.setTransform(message, "test", is_static);
}

// T_target_source maps a point from source to target: the camera's origin lies where it was set.
TEST(Lookup, IsThatAtTheStamp) {
  TransformBuffer buffer;
  set(buffer, 10.0, 0.0);
  set(buffer, 10.2, 0.4);
  const LookupResult found = lookup(buffer, "base", "camera", ros::Time(10.05), kNoWait);
  ASSERT_TRUE(found.T_target_source);
  EXPECT_TRUE(isometryNear(*found.T_target_source,
                           Eigen::Isometry3d(Eigen::Translation3d(0.1, 0.0, 1.0)), 1e-6, 1e-6));
}

TEST(Lookup, MissingFrameGivesReason) {
  TransformBuffer buffer;
  set(buffer, 10.0, 0.0);
  const LookupResult found = lookup(buffer, "world", "camera", ros::Time(10.0), kNoWait);
  EXPECT_FALSE(found.T_target_source);
  EXPECT_NE(found.reason.find("world"), std::string::npos) << found.reason;
  EXPECT_EQ(found.reason.find_last_not_of(". ") + 1, found.reason.size()) << found.reason;
}

TEST(Lookup, NeverTakesTheLatestInstead) {
  TransformBuffer buffer;
  set(buffer, 10.0, 0.0);
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(11.0), kNoWait).T_target_source);
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(), kNoWait).T_target_source);
}

TEST(Lookup, WaitsForLateTransform) {
  TransformBuffer buffer;
  set(buffer, 10.0, 0.0);
  std::thread late([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    set(buffer, 10.15, 0.4);
  });
  const LookupResult found =
      lookup(buffer, "base", "camera", ros::Time(10.1), duration<double>(10.0));
  late.join();
  EXPECT_TRUE(found.T_target_source) << found.reason;
}

TEST(Lookup, EndsAtItsTimeout) {
  TransformBuffer buffer;
  const auto start = steady_clock::now();
  EXPECT_FALSE(lookup(buffer, "a", "b", ros::Time(1.0), duration<double>(0.1)).T_target_source);
  const double waited = duration<double>(steady_clock::now() - start).count();
  EXPECT_GE(waited, 0.1);
  EXPECT_LT(waited, 5.0);  // generous: the machine may be busy
}

// The robot went from 0 to 0.4 m and nobody said how: where it was in between is not known.
TEST(Lookup, MakesNothingUpInAGap) {
  TransformBuffer buffer(0.5);
  for (const double time : {9.0, 9.5, 10.0}) set(buffer, time, 0.0);
  for (const double time : {11.0, 11.25, 11.75}) set(buffer, time, 0.4);
  const auto at = [&](double time) {
    return lookup(buffer, "base", "camera", ros::Time(time), kNoWait);
  };
  const LookupResult in_gap = at(10.25);
  EXPECT_FALSE(in_gap.T_target_source);
  for (const char* words :
       {"camera", "0.250 s before", "0.750 s after", "1.000 s", "0.500 s", "tf_gap_max"})
    EXPECT_NE(in_gap.reason.find(words), std::string::npos) << words << ": " << in_gap.reason;
  for (const double time : {9.0, 9.3, 10.0, 11.0, 11.1, 11.5, 11.75})
    EXPECT_TRUE(at(time).T_target_source) << time << ": " << at(time).reason;
  EXPECT_FALSE(at(8.9).T_target_source);
  EXPECT_FALSE(at(11.8).T_target_source);
}

// One link of several, on either side, is enough; links that are not on the way do not matter.
TEST(Lookup, LooksForGapsOnTheWayAlone) {
  TransformBuffer buffer(0.2);
  set(buffer, 0.0, 0.1, "flange", "camera", true);
  set(buffer, 0.0, 0.1, "world", "base", true);
  for (const double time : {10.0, 10.1, 10.2, 10.3}) {
    set(buffer, time, 0.0, "base", "flange");
    set(buffer, time, 0.0, "world", "table");
  }
  for (const double time : {10.0, 10.3}) {
    set(buffer, time, 0.0, "base", "conveyor");
    set(buffer, time, 0.0, "root", "world");
  }
  const auto finds = [&](const std::string& target, const std::string& source) {
    return lookup(buffer, target, source, ros::Time(10.15), kNoWait).T_target_source.has_value();
  };
  EXPECT_TRUE(finds("base", "camera"));
  EXPECT_TRUE(finds("table", "camera"));  // by way of world, whose own gap is not on the way
  EXPECT_FALSE(finds("conveyor", "camera"));
  EXPECT_FALSE(finds("camera", "conveyor"));
  EXPECT_FALSE(finds("root", "camera"));
  EXPECT_TRUE(finds("flange", "camera"));
}

// Drivers of tf's first version say "/flange", tf2 keeps "flange".
TEST(Lookup, KnowsGapsOfFramesWithASlashInFront) {
  TransformBuffer buffer(0.2);
  for (const double time : {10.0, 10.3}) set(buffer, time, 0.0, "/base", "/camera");
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(10.1), kNoWait).T_target_source);
  EXPECT_TRUE(lookup(buffer, "base", "camera", ros::Time(10.3), kNoWait).T_target_source);
}

TEST(Lookup, KnowsSamplesThatCameOutOfOrder) {
  TransformBuffer buffer(0.2);
  for (const double time : {10.3, 10.0, 10.15}) set(buffer, time, 0.0);
  EXPECT_TRUE(lookup(buffer, "base", "camera", ros::Time(10.1), kNoWait).T_target_source);
  EXPECT_TRUE(lookup(buffer, "base", "camera", ros::Time(10.2), kNoWait).T_target_source);
}

TEST(Lookup, ASampleThatComesLateFillsAGap) {
  TransformBuffer buffer(0.2);
  set(buffer, 10.0, 0.0);
  set(buffer, 10.3, 0.0);
  std::thread late([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    set(buffer, 10.15, 0.0);
  });
  const auto found = lookup(buffer, "base", "camera", ros::Time(10.1), duration<double>(10.0));
  late.join();
  EXPECT_TRUE(found.T_target_source) << found.reason;
}

// After the clock was set back the old samples are gone, and with them their moments.
TEST(Lookup, ForgetsWhatWasClearedButForStaticTransforms) {
  TransformBuffer buffer(0.2);
  set(buffer, 0.0, 0.1, "camera", "lens", true);
  set(buffer, 10.0, 0.0);
  set(buffer, 10.1, 0.0);
  buffer.clear();
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(10.05), kNoWait).T_target_source);
  EXPECT_TRUE(lookup(buffer, "camera", "lens", ros::Time(10.05), kNoWait).T_target_source);
  set(buffer, 5.0, 0.3);
  set(buffer, 5.1, 0.3);
  EXPECT_TRUE(lookup(buffer, "base", "camera", ros::Time(5.05), kNoWait).T_target_source);
  set(buffer, 10.2, 0.0);
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(10.1), kNoWait).T_target_source);
}

// tf2 keeps ten seconds: what it has forgotten has no moment either, and costs no memory.
TEST(Lookup, WhatTfTakesNotIsNoSample) {
  TransformBuffer buffer(0.2);
  set(buffer, 20.0, 0.0);
  set(buffer, 20.3, 0.0);
  geometry_msgs::TransformStamped bad;
  bad.header.frame_id = "base";
  bad.child_frame_id = "camera";
  bad.header.stamp = ros::Time(20.15);
  bad.transform.translation.x = std::nan("");
  bad.transform.rotation.w = 1.0;
  EXPECT_FALSE(buffer.setTransform(bad, "test"));
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(20.1), kNoWait).T_target_source);
  for (double time = 20.4; time < 40.0; time += 0.1) set(buffer, time, 0.0);
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(20.45), kNoWait).T_target_source);
  EXPECT_TRUE(lookup(buffer, "base", "camera", ros::Time(35.05), kNoWait).T_target_source);
}

TEST(ClockWatch, TellsOnceThatTheClockWasSetBack) {
  ros::Time::init();
  ClockWatch watch;
  ros::Time::setNow(ros::Time(100.0));
  EXPECT_FALSE(watch.wentBack());
  ros::Time::setNow(ros::Time(101.0));
  EXPECT_FALSE(watch.wentBack());
  ros::Time::setNow(ros::Time(50.0));
  EXPECT_TRUE(watch.wentBack());
  EXPECT_FALSE(watch.wentBack());
  ros::Time::setNow(ros::Time(50.1));
  EXPECT_FALSE(watch.wentBack());
}

}  // namespace
}  // namespace planar_bin_picking_ros
