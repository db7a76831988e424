// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "input/image_inbox.h"

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

#include <atomic>
#include <thread>
#include <vector>

namespace planar_bin_picking_ros {
namespace {

using std::chrono::seconds;
using std::chrono::steady_clock;

void push(ImageInbox& inbox, const double stamp) {
  const auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.stamp = ros::Time(stamp);
  inbox.push(image, boost::make_shared<sensor_msgs::CameraInfo>());
}

FrameWish from(const double stamp) { return {ros::Time(stamp), SteadyTime{}, {}}; }

/// ROS time as the inbox reads it; these tests have no /clock.
class ImageInboxTime : public testing::Environment {
 public:
  void SetUp() override {
    ros::Time::init();
    ros::Time::setNow(ros::Time(10.0));
  }
};
const auto* const kTime = testing::AddGlobalTestEnvironment(new ImageInboxTime);

TEST(ImageInbox, GivesStoredImageThatIsNewEnough) {
  ImageInbox inbox;
  push(inbox, 10.0);
  const auto frame = inbox.wait(from(9.0), steady_clock::now());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image->header.stamp, ros::Time(10.0));
}

TEST(ImageInbox, NeverGivesAnOlderImage) {
  ImageInbox inbox;
  push(inbox, 10.0);
  EXPECT_FALSE(inbox.wait(from(10.5), steady_clock::now()));
}

// A bag that starts over: the stored image has a later stamp than the clock, yet it is an old one.
TEST(ImageInbox, NeverGivesAnImageThatCameBefore) {
  ImageInbox inbox;
  push(inbox, 10.0);
  EXPECT_FALSE(inbox.wait({ros::Time(3.0), steady_clock::now(), {}}, steady_clock::now()));
}

// A camera whose clock is ahead: the stamp is later than the robot's stop, the image is not.
TEST(ImageInbox, NeverGivesAnImageThatCameBeforeByTheClock) {
  ImageInbox inbox;
  ros::Time::setNow(ros::Time(10.0));
  push(inbox, 10.09);
  EXPECT_FALSE(inbox.wait({ros::Time(10.05), {}, ros::Time(10.05)}, steady_clock::now()));
  const auto frame = inbox.wait({ros::Time(10.0), {}, ros::Time(10.0)}, steady_clock::now());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->clock, ros::Time(10.0));
}

TEST(ImageInbox, ForgetsItsImage) {
  ImageInbox inbox;
  push(inbox, 10.0);
  ASSERT_TRUE(inbox.newest());
  inbox.forget();
  EXPECT_FALSE(inbox.newest());
  EXPECT_FALSE(inbox.wait(from(0.0), steady_clock::now()));
  push(inbox, 3.0);
  EXPECT_TRUE(inbox.wait(from(0.0), steady_clock::now()));
}

TEST(ImageInbox, WakesEveryWaiter) {
  ImageInbox inbox;
  std::vector<std::thread> waiters;
  std::atomic<int> served{0};
  for (int i = 0; i < 3; ++i) {
    waiters.emplace_back([&] {
      if (inbox.wait(from(5.0), steady_clock::now() + seconds(30))) ++served;
    });
  }
  push(inbox, 4.0);  // too old: nobody may take it
  push(inbox, 6.0);
  for (auto& waiter : waiters) waiter.join();
  EXPECT_EQ(served, 3);
  EXPECT_EQ(inbox.count(), 2u);
}

TEST(ImageInbox, EndsAtItsDeadline) {
  ImageInbox inbox;
  const auto deadline = steady_clock::now() + std::chrono::milliseconds(50);
  EXPECT_FALSE(inbox.wait(from(0.0), deadline));
  EXPECT_GE(steady_clock::now(), deadline);
}

TEST(ImageInbox, CloseEndsWaiting) {
  ImageInbox inbox;
  std::thread waiter(
      [&] { EXPECT_FALSE(inbox.wait(from(0.0), steady_clock::now() + seconds(30))); });
  const auto start = steady_clock::now();
  inbox.close();
  waiter.join();
  EXPECT_LT(steady_clock::now() - start, seconds(20));
}

}  // namespace
}  // namespace planar_bin_picking_ros
