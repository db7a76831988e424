// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "transforms.h"

#include "convert.h"
#include "support/matchers.h"

#include <gtest/gtest.h>
#include <tf2/buffer_core.h>

#include <thread>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::isometryNear;
using std::chrono::duration;
using std::chrono::steady_clock;

const duration<double> kNoWait(0.0);

void set(tf2::BufferCore& buffer, const double time, const double x) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = "base";
  message.header.stamp = ros::Time(time);
  message.child_frame_id = "camera";
  message.transform = toTransformMsg(Eigen::Isometry3d(Eigen::Translation3d(x, 0.0, 1.0)));
  buffer.setTransform(message, "test");
}

// T_target_source maps a point from source to target: the camera's origin lies where it was set.
TEST(Lookup, IsThatAtTheStamp) {
  tf2::BufferCore buffer;
  set(buffer, 10.0, 0.0);
  set(buffer, 11.0, 0.4);
  const LookupResult found = lookup(buffer, "base", "camera", ros::Time(10.25), kNoWait);
  ASSERT_TRUE(found.T_target_source);
  EXPECT_TRUE(isometryNear(*found.T_target_source,
                           Eigen::Isometry3d(Eigen::Translation3d(0.1, 0.0, 1.0)), 1e-6, 1e-6));
}

TEST(Lookup, MissingFrameGivesReason) {
  tf2::BufferCore buffer;
  set(buffer, 10.0, 0.0);
  const LookupResult found = lookup(buffer, "world", "camera", ros::Time(10.0), kNoWait);
  EXPECT_FALSE(found.T_target_source);
  EXPECT_NE(found.reason.find("world"), std::string::npos) << found.reason;
}

TEST(Lookup, NeverTakesTheLatestInstead) {
  tf2::BufferCore buffer;
  set(buffer, 10.0, 0.0);
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(11.0), kNoWait).T_target_source);
  EXPECT_FALSE(lookup(buffer, "base", "camera", ros::Time(), kNoWait).T_target_source);
}

TEST(Lookup, WaitsForLateTransform) {
  tf2::BufferCore buffer;
  set(buffer, 10.0, 0.0);
  std::thread late([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    set(buffer, 11.0, 0.4);
  });
  const LookupResult found =
      lookup(buffer, "base", "camera", ros::Time(10.5), duration<double>(10.0));
  late.join();
  EXPECT_TRUE(found.T_target_source) << found.reason;
}

TEST(Lookup, EndsAtItsTimeout) {
  tf2::BufferCore buffer;
  const auto start = steady_clock::now();
  EXPECT_FALSE(lookup(buffer, "a", "b", ros::Time(1.0), duration<double>(0.1)).T_target_source);
  const double waited = duration<double>(steady_clock::now() - start).count();
  EXPECT_GE(waited, 0.1);
  EXPECT_LT(waited, 5.0);  // generous: the machine may be busy
}

}  // namespace
}  // namespace planar_bin_picking_ros
