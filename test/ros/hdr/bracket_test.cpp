// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hdr/bracket.h"

#include <gtest/gtest.h>
#include <ros/time.h>
#include <boost/make_shared.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <thread>

namespace planar_bin_picking_ros {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(const Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A camera that takes a frame when it is asked, before it answers. Three decades of light.
class FakeCamera {
 public:
  explicit FakeCamera(ImageInbox* inbox) : inbox_(inbox) {}

  void set(double seconds) {
    commands.push_back(seconds);
    if (commands.size() == fail_at) throw std::runtime_error("the camera refused");
    if (obeys) exposures_.assign(static_cast<std::size_t>(late) + 1, exposures_.back());
    exposures_.push_back(obeys ? factor * seconds : exposures_.back());
  }

  void ask() {
    ++asked;
    if (slow > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(slow));
    if (asked > mute_after) return;
    if (exposures_.size() > 1) exposures_.pop_front();
    take(exposures_.front(), ros::Time::now());
  }

  void take(double seconds, const ros::Time& stamp) {
    auto image = boost::make_shared<sensor_msgs::Image>();
    image->header.stamp = stamp;
    image->header.frame_id = "camera";
    image->width = 200;
    image->height = 40;
    image->step = 200;
    image->encoding = "mono8";
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 200; ++x) {
        const double light = level * std::pow(1000.0, x / 199.0) * seconds;
        image->data.push_back(
            static_cast<std::uint8_t>(std::lround(std::clamp(light, 0.0, 255.0))));
      }
    }
    inbox_->push(image, boost::make_shared<sensor_msgs::CameraInfo>());
  }

  std::vector<double> commands;
  std::size_t fail_at = 0;  // command, counted from 1
  bool obeys = true;
  double factor = 1.0, level = 100.0, slow = 0.0;
  int late = 0, asked = 0, mute_after = 100000;

 private:
  ImageInbox* inbox_;
  std::deque<double> exposures_{0.008};
};

class Bracket : public testing::Test {
 protected:
  Bracket() {
    ros::Time::init();
    params_.exposures_ms = {32.0, 2.0, 128.0, 8.0, 0.5};
    params_.frame_timeout = 0.3;
    params_.trigger_service = "trigger";
  }

  BracketTaker taker() {
    return BracketTaker(
        params_, [this](double seconds) { camera_.set(seconds); }, [this] { camera_.ask(); },
        &inbox_);
  }
  std::vector<ExposedFrame> take() {
    BracketTaker taker = this->taker();
    const ExposedFrame single = taker.takeSingle(0.008);
    camera_.asked = 0;
    return taker.take(single);
  }
  std::string failure() {
    try {
      take();
    } catch (const BracketFailure& error) {
      return error.what();
    }
    return "";
  }
  static bool has(const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
  }

  HdrNodeParams params_;
  ImageInbox inbox_;
  FakeCamera camera_{&inbox_};
};

// From the single exposure down, from it up, and back to it; one frame for each.
TEST_F(Bracket, TakesEachExposureOnceInItsOrder) {
  const auto frames = take();
  const std::vector<double> down_up{0.002, 0.0005, 0.032, 0.128, 0.008};
  ASSERT_EQ(camera_.commands.size(), down_up.size());
  for (std::size_t i = 0; i < down_up.size(); ++i) {
    EXPECT_NEAR(camera_.commands[i], down_up[i], 1e-9);
  }
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_DOUBLE_EQ(frames[0].seconds, 0.008);
  for (std::size_t i = 1; i < 5; ++i) {
    EXPECT_NEAR(frames[i].seconds, down_up[i - 1], 1e-9);
    // 100 light per second at the left, 100000 at the right
    const auto& grey = frames[i].frame.image->data;
    const double expected = 100.0 * std::pow(1000.0, 100.0 / 199.0) * frames[i].seconds;
    EXPECT_NEAR(grey[100], std::min(255.0, expected), 1.0);
  }
  EXPECT_EQ(camera_.asked, 5);
}

TEST_F(Bracket, ExposureWithinOnePercentOfTheSingleIsNotTakenTwice) {
  params_.exposures_ms = {8.07, 7.93, 8.2};
  EXPECT_EQ(take().size(), 2u);
  EXPECT_EQ(camera_.commands.size(), 2u);
}

TEST_F(Bracket, WaitsForTheFrameThatHasTheExposure) {
  camera_.late = 2;  // frames still under way
  const auto frames = take();
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_EQ(camera_.asked, 5 * 3);
}

TEST_F(Bracket, ToleranceIsRelative) {
  params_.exposure_tolerance = 0.2;
  params_.exposures_ms = {2.0, 8.0};
  for (const double factor : {1.16, 1.0 / 1.16}) {
    camera_ = FakeCamera(&inbox_);
    camera_.factor = factor;
    EXPECT_EQ(failure(), "") << factor;
  }
  for (const double factor : {1.25, 1.0 / 1.25}) {
    camera_ = FakeCamera(&inbox_);
    camera_.factor = factor;
    EXPECT_TRUE(has(failure(), "asked for 2 ms, but the newest of 10 frames")) << factor;
  }
}

// The camera answers after its frame is out: nothing ever waits.
TEST_F(Bracket, CameraThatIgnoresIsAskedSoManyTimes) {
  camera_.obeys = false;
  for (const int limit : {3, 7}) {
    params_.triggers_max = limit;
    const std::string said = failure();
    EXPECT_TRUE(has(said, "asked for 2 ms, but the newest of " + std::to_string(limit) +
                              " frames since then looks like 8"))
        << said;
    EXPECT_EQ(camera_.asked, limit + 1);  // and one that has the single exposure still
  }
}

TEST_F(Bracket, CameraThatIgnoresEndsInTime) {
  params_.trigger_service.clear();  // runs freely: no limit on frames
  camera_.obeys = false;
  const auto start = Clock::now();
  EXPECT_TRUE(has(failure(), "looks like 8"));
  EXPECT_GE(secondsSince(start), 0.3);
  EXPECT_LT(secondsSince(start), 0.9);
  EXPECT_GT(camera_.asked, 10);
}

TEST_F(Bracket, SlowTriggerIsNotAskedAfterTheDeadline) {
  camera_.obeys = false;
  camera_.slow = 0.2;
  const auto start = Clock::now();
  EXPECT_FALSE(failure().empty());
  EXPECT_LT(secondsSince(start), 1.5);
  EXPECT_LE(camera_.asked, 4);
}

TEST_F(Bracket, BracketHasATimeLimit) {
  camera_.slow = 0.06;
  params_.bracket_timeout = 0.1;
  const auto start = Clock::now();
  const std::string said = failure();
  EXPECT_TRUE(has(said, "3 of the exposures took longer than ~hdr/bracket_timeout")) << said;
  EXPECT_LT(secondsSince(start), 0.6);
  ASSERT_EQ(camera_.commands.size(), 3u);
  EXPECT_DOUBLE_EQ(camera_.commands.back(), 0.008);  // all the same it goes back
}

TEST_F(Bracket, NoFrame) {
  params_.frame_timeout = 0.25;
  BracketTaker taker = this->taker();
  const ExposedFrame single = taker.takeSingle(0.008);
  camera_.mute_after = camera_.asked;
  const auto start = Clock::now();
  try {
    taker.take(single);
    FAIL() << "no failure";
  } catch (const BracketFailure& error) {
    EXPECT_TRUE(has(error.what(), "no frame came within 0.25 s after the camera took 2 ms"))
        << error.what();
  }
  EXPECT_GE(secondsSince(start), 0.49);  // the exposure, and the way back
  EXPECT_LT(secondsSince(start), 1.2);
  EXPECT_EQ(camera_.commands.size(), 2u);
}

TEST_F(Bracket, BlindFramesAreTakenOnTrust) {
  camera_.level = 1e6;  // all white but for the shortest
  params_.exposures_ms = {16.0, 64.0};
  for (const int blind : {1, 4}) {
    params_.blind_frames = blind;
    EXPECT_EQ(take().size(), 3u);
    EXPECT_EQ(camera_.asked, 3 * blind);
  }
  params_.blind_frames = 6;
  params_.triggers_max = 5;
  EXPECT_TRUE(has(failure(), "asked for 16 ms, and 5 frames since then are all dark or all white"));
}

TEST_F(Bracket, FailingCommandGoesBackAndSaysWhy) {
  camera_.fail_at = 2;
  EXPECT_EQ(failure(), "the camera refused");
  ASSERT_EQ(camera_.commands.size(), 3u);
  EXPECT_DOUBLE_EQ(camera_.commands.back(), 0.008);
}

TEST_F(Bracket, FailingWayBackSaysSo) {
  camera_.fail_at = 5;
  EXPECT_EQ(failure(), "back to the single exposure: the camera refused");
}

TEST_F(Bracket, FirstReasonIsTheOneThatIsSaid) {
  params_.exposures_ms = {2.0, 32.0};
  params_.triggers_max = 3;
  camera_.factor = 2.0;  // both fail, the way back as well
  const std::string said = failure();
  EXPECT_TRUE(has(said, "asked for 2 ms")) << said;
  EXPECT_FALSE(has(said, "back to")) << said;
}

// Each frame is held against the nearest known one: against the single one alone, half a decade of
// light would be left here, and the frame taken on trust after three.
TEST_F(Bracket, HoldsFramesAgainstTheNearest) {
  params_.exposures_ms = {2.0, 0.5, 0.125};
  params_.blind_frames = 10;
  camera_.late = 1;
  const auto frames = take();
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(camera_.asked, 8);
}

TEST_F(Bracket, SingleIsNewerThanTheCall) {
  params_.frame_timeout = 0.2;
  camera_.take(0.008, ros::Time::now());  // before the call
  camera_.mute_after = 0;
  BracketTaker taker = this->taker();
  const auto start = Clock::now();
  EXPECT_THROW(taker.takeSingle(0.008), std::runtime_error);
  EXPECT_GE(secondsSince(start), 0.19);
  EXPECT_LT(secondsSince(start), 1.0);
  // Taken before, and come in during the call: it was long under way.
  const ros::Time before = ros::Time::now();
  BracketTaker late(
      params_, [](double) {}, [&] { camera_.take(0.008, before - ros::Duration(0.01)); }, &inbox_);
  EXPECT_THROW(late.takeSingle(0.008), std::runtime_error);
  // Come in before, with a stamp from the future.
  camera_.take(0.008, ros::Time::now() + ros::Duration(10.0));
  EXPECT_THROW(taker.takeSingle(0.008), std::runtime_error);
  camera_.mute_after = 1000;
  EXPECT_DOUBLE_EQ(taker.takeSingle(0.5).seconds, 0.5);
}

TEST_F(Bracket, EndsAtOnceWhenTheNodeEnds) {
  params_.frame_timeout = 20.0;
  BracketTaker taker = this->taker();
  const ExposedFrame single = taker.takeSingle(0.008);
  inbox_.close();
  const auto start = Clock::now();
  try {
    taker.take(single);
    FAIL() << "no failure";
  } catch (const BracketFailure& error) {
    EXPECT_TRUE(has(error.what(), "the node shut down")) << error.what();
  }
  EXPECT_LT(secondsSince(start), 2.0);
}

}  // namespace
}  // namespace planar_bin_picking_ros
