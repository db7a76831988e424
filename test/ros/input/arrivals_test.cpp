// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "input/arrivals.h"

#include <gtest/gtest.h>

namespace planar_bin_picking_ros {
namespace {

void note(const double stamp, const int milliseconds, Arrivals* arrivals) {
  arrivals->note(ros::Time(stamp), SteadyTime{} + std::chrono::milliseconds(milliseconds));
}

TEST(Arrivals, TellTheNewest) {
  Arrivals images;
  EXPECT_EQ(images.count(), 0u);
  note(10.0, 1000, &images);
  note(10.2, 1200, &images);
  note(10.4, 1400, &images);
  EXPECT_EQ(images.count(), 3u);
  EXPECT_EQ(images.stamp(), ros::Time(10.4));
  EXPECT_EQ(images.received(), SteadyTime{} + std::chrono::milliseconds(1400));
}

/// Five shots a second, camera_info stamped 0.25 s late.
class Shots : public testing::Test {
 protected:
  void shoot(const int shot) {
    note(10.0 + 0.2 * shot, 1000 + 200 * shot, &images_);
    note(10.25 + 0.2 * shot, 1003 + 200 * shot, &infos_);
  }
  Arrivals images_, infos_;
};

TEST_F(Shots, OneEach) {
  shoot(0);
  EXPECT_NEAR(images_.lead(infos_, {}), 0.25, 1e-6);
  EXPECT_NEAR(infos_.lead(images_, {}), -0.25, 1e-6);
}

TEST_F(Shots, LookedAtBetweenImageAndInfo) {
  shoot(0);
  shoot(1);
  note(10.4, 1400, &images_);  // newest less newest: 0.05
  EXPECT_NEAR(images_.lead(infos_, {}), 0.25, 1e-6);
}

TEST_F(Shots, LookedAtBetweenInfoAndImage) {
  shoot(0);
  shoot(1);
  note(10.65, 1400, &infos_);  // newest less newest: 0.45
  EXPECT_NEAR(images_.lead(infos_, {}), 0.25, 1e-6);
}

TEST_F(Shots, InfoOfTheFirstImageAlone) {
  shoot(0);
  note(10.2, 1200, &images_);
  EXPECT_NEAR(images_.lead(infos_, {}), 0.25, 1e-6);
}

/// Of a driver whose two stamps agree only now and then, the shot since the call counts, although
/// the one before came closer together.
TEST_F(Shots, BeforeTheCallDoNotCount) {
  note(9.8, 800, &images_);
  note(9.8, 801, &infos_);
  shoot(0);
  EXPECT_EQ(images_.lead(infos_, {}), 0.0);
  EXPECT_NEAR(images_.lead(infos_, SteadyTime{} + std::chrono::milliseconds(900)), 0.25, 1e-6);
  EXPECT_EQ(images_.lead(infos_, SteadyTime{} + std::chrono::milliseconds(1001)), 0.0);
}

TEST(Arrivals, AStampOfZeroIsFarFromTheClock) {
  Arrivals images, infos;
  note(1.6e9, 1000, &images);
  note(0.0, 1000, &infos);
  EXPECT_NEAR(images.lead(infos, {}), -1.6e9, 1.0);
}

}  // namespace
}  // namespace planar_bin_picking_ros
