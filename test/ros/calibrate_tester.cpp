// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Starts a calibrator and waits for its last status. Parameters: `calibrator` (name), `status`
/// (how the last status begins), `words` (what is in it), `moves_max`.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <std_msgs/Int32.h>
#include <std_msgs/String.h>
#include <std_srvs/Trigger.h>

#include <chrono>
#include <functional>
#include <thread>
#include <vector>

namespace {

std_srvs::Trigger call(const std::string& service) {
  std_srvs::Trigger trigger;
  EXPECT_TRUE(ros::service::waitForService(service, ros::Duration(30.0))) << service;
  EXPECT_TRUE(ros::service::call(service, trigger)) << service;
  return trigger;
}

class Calibrate : public testing::Test {
 protected:
  Calibrate() {
    status_ = nh_.subscribe<std_msgs::String>(
        name_ + "/status", 100,
        [this](const std_msgs::StringConstPtr& m) { said_.push_back(m->data); });
    moves_sub_ = nh_.subscribe<std_msgs::Int32>(
        "moves", 100, [this](const std_msgs::Int32ConstPtr& m) { moves_ = m->data; });
  }

  bool await(const std::function<bool()>& condition, double seconds) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!condition() && std::chrono::steady_clock::now() < deadline) {
      ros::spinOnce();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return condition();
  }

  bool ended() const {
    if (said_.empty()) return false;
    for (const char* word : {"GOOD", "POOR", "REFUSED", "ABORTED", "FAILED"}) {
      if (said_.back().rfind(word, 0) == 0) return true;
    }
    return false;
  }

  ros::NodeHandle nh_;
  const std::string name_ = ros::NodeHandle("~").param<std::string>("calibrator", "calibrator");
  std::vector<std::string> said_;
  int moves_ = 0;
  ros::Subscriber status_, moves_sub_;
};

TEST_F(Calibrate, EndsAsExpected) {
  const ros::NodeHandle pnh("~");
  // A camera and its tf need a moment; nothing moves before ~start.
  ASSERT_TRUE(await([&] { return !said_.empty(); }, 30.0)) << "no status";
  EXPECT_EQ(moves_, 0);
  ASSERT_TRUE(call(name_ + "/start").response.success);
  EXPECT_FALSE(call(name_ + "/start").response.success);
  ASSERT_TRUE(await([&] { return ended(); }, 150.0)) << (said_.empty() ? "" : said_.back());
  EXPECT_EQ(said_.back().rfind(pnh.param<std::string>("status", "GOOD"), 0), 0u) << said_.back();
  EXPECT_NE(said_.back().find(pnh.param<std::string>("words", "")), std::string::npos)
      << said_.back();
  EXPECT_LE(moves_, pnh.param("moves_max", 100));
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "calibrate_tester");
  const ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
