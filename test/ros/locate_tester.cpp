// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// The tester of all rostests: calls a locator and compares its answer with what its parameters
/// say. Everything waits with a deadline. Parameters, all private:
///   service            what to call
///   part, face, timeout, max_parts   of the request
///   callers            how many call at once
///   status             that is expected, as a number (LocatePart.srv)
///   message            words that must stand in the answer's message
///   seconds_max        within which the answer must be there
///   truth              file with the parts in camera_frame (test/data/*/truth.yaml), and with it
///   camera_frame, recall_min, precision_min, lateral_max_mm, depth_max_mm, angle_max_deg
///   cases/<name>/...   all of the above but truth, once per case, for --gtest_filter=Cases.*

#include "shared/convert.h"
#include "support/matchers.h"
#include "truth.h"

#include <gtest/gtest.h>
#include <planar_bin_picking/LocatePart.h>
#include <planar_bin_picking/LocatedParts.h>
#include <ros/ros.h>
#include <ros/topic.h>
#include <sensor_msgs/Image.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <thread>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::isometryNear;
using planar_bin_picking::LocatedPart;
using planar_bin_picking::LocatedParts;
using planar_bin_picking::LocatePart;
using std::chrono::duration;
using std::chrono::steady_clock;

const std::chrono::seconds kDeadline(20);  // for whatever must come at all; machines may be busy

template <class Value>
Value required(const std::string& name, const ros::NodeHandle& params = ros::NodeHandle("~")) {
  Value value;
  if (!params.getParam(name, value)) {
    throw std::runtime_error("the test does not set " + params.resolveName(name));
  }
  return value;
}

/// One caller or several at once, as parameters say.
struct Call {
  bool answered = false;
  double seconds = 0.0;
  LocatePart::Response response;
};

Call callOnce(const ros::NodeHandle& params) {
  LocatePart service;
  service.request.part = params.param<std::string>("part", "");
  service.request.face = static_cast<std::uint8_t>(params.param("face", 0));
  service.request.max_parts = static_cast<std::uint32_t>(params.param("max_parts", 0));
  service.request.timeout = ros::Duration(params.param("timeout", 0.0));
  const auto start = steady_clock::now();
  Call call;
  call.answered = ros::service::call(required<std::string>("service", params), service);
  call.seconds = duration<double>(steady_clock::now() - start).count();
  call.response = service.response;
  return call;
}

/// @return  nothing where the service does not come up
std::vector<Call> callLocator(const ros::NodeHandle& params) {
  const auto deadline = steady_clock::now() + kDeadline;
  while (!ros::service::exists(required<std::string>("service", params), false)) {
    if (steady_clock::now() > deadline) return {};
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::vector<std::future<Call>> futures;
  for (int i = 0; i < params.param("callers", 1); ++i) {
    futures.push_back(std::async(std::launch::async, callOnce, params));
  }
  std::vector<Call> calls;
  for (auto& future : futures) calls.push_back(future.get());
  return calls;
}

void expectAsAsked(const std::vector<Call>& calls, const ros::NodeHandle& params) {
  ASSERT_FALSE(calls.empty()) << "no service " << required<std::string>("service", params);
  for (const Call& call : calls) {
    ASSERT_TRUE(call.answered);
    EXPECT_EQ(call.response.status, required<int>("status", params)) << call.response.message;
    EXPECT_NE(call.response.message.find(params.param<std::string>("message", "")),
              std::string::npos)
        << call.response.message;
    EXPECT_LE(call.seconds, params.param("seconds_max", 60.0));
    EXPECT_EQ(call.response.parts.empty(), call.response.status != LocatePart::Response::OK);
  }
}

TEST(Cases, AreAnsweredAsAsked) {
  XmlRpc::XmlRpcValue cases = required<XmlRpc::XmlRpcValue>("cases");
  for (const auto& one : cases) {
    SCOPED_TRACE(one.first);
    const ros::NodeHandle params("~cases/" + one.first);
    expectAsAsked(callLocator(params), params);
  }
}

/// Calls once for all cases.
class Locate : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    buffer_ = std::make_unique<tf2_ros::Buffer>();
    listener_ = std::make_unique<tf2_ros::TransformListener>(*buffer_);
    calls_ = callLocator(ros::NodeHandle("~"));
  }

  static void TearDownTestSuite() {
    listener_.reset();
    buffer_.reset();
  }

  void SetUp() override {
    ASSERT_FALSE(calls_.empty()) << "no service " << required<std::string>("service");
  }

  static const LocatePart::Response& response() { return calls_.back().response; }

  /// T_target_source at any time, or nothing at the deadline.
  static std::optional<Eigen::Isometry3d> lookup(const std::string& target,
                                                 const std::string& source,
                                                 const ros::Time& stamp) {
    const auto deadline = steady_clock::now() + kDeadline;
    while (!buffer_->canTransform(target, source, stamp)) {
      if (steady_clock::now() > deadline) return std::nullopt;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return fromMsg(buffer_->lookupTransform(target, source, stamp).transform);
  }

  template <class Message>
  static boost::shared_ptr<const Message> latched(const std::string& topic) {
    ros::NodeHandle nh(ros::names::parentNamespace(required<std::string>("service")));
    // Wall time: with simulated time waitForMessage's own time-out might never end.
    auto future = std::async(std::launch::async,
                             [&] { return ros::topic::waitForMessage<Message>(topic, nh); });
    if (future.wait_for(kDeadline) == std::future_status::timeout) ros::shutdown();
    return future.get();
  }

  static std::vector<Call> calls_;
  static std::unique_ptr<tf2_ros::Buffer> buffer_;
  static std::unique_ptr<tf2_ros::TransformListener> listener_;
};

std::vector<Call> Locate::calls_;
std::unique_ptr<tf2_ros::Buffer> Locate::buffer_;
std::unique_ptr<tf2_ros::TransformListener> Locate::listener_;

TEST_F(Locate, AnswersAsExpected) { expectAsAsked(calls_, ros::NodeHandle("~")); }

TEST_F(Locate, EveryCallerGetsTheSameParts) {
  for (const Call& call : calls_) EXPECT_EQ(call.response.parts.size(), response().parts.size());
}

TEST_F(Locate, PosesMatchTruth) {
  ASSERT_FALSE(response().parts.empty()) << response().message;
  const std_msgs::Header& header = response().parts[0].header;
  const auto T_camera_header =
      lookup(required<std::string>("camera_frame"), header.frame_id, header.stamp);
  ASSERT_TRUE(T_camera_header);
  Truth truth(required<std::string>("truth"));
  TruthTolerance tolerance;
  tolerance.lateral = 1e-3 * required<double>("lateral_max_mm");
  tolerance.depth = 1e-3 * required<double>("depth_max_mm");
  tolerance.angle = M_PI / 180.0 * required<double>("angle_max_deg");
  int right = 0;
  for (const LocatedPart& part : response().parts) {
    const bool front = part.face == LocatedPart::FRONT;
    right += truth.take(part.part, front, *T_camera_header * fromMsg(part.pose.pose), tolerance);
    if (&part == &response().parts.front()) {
      EXPECT_EQ(right, 1) << "the first match is wrong";
    }
  }
  EXPECT_GE(right, required<double>("precision_min") * response().parts.size());
  EXPECT_GE(truth.pickableTaken(), required<double>("recall_min") * truth.pickable());
  RecordProperty("right", right);
  RecordProperty("found", static_cast<int>(response().parts.size()));
}

// What lies free comes first, see rank.h and pick/overlap.h.
TEST_F(Locate, RankedBestFirst) {
  constexpr double kFree = 0.97, kCarries = 0.9;
  constexpr double kReach = 0.144;  // metres, two radii of the bracket
  const auto& parts = response().parts;
  const auto merit = [](const LocatedPart& part) {
    return part.score * part.visible_fraction * part.visible_fraction *
           (part.visible_fraction < kFree ? kCarries : 1.0);
  };
  // Another part's pose may show that it lies on this one, which then comes later.
  const auto isAlone = [&](const LocatedPart& part) {
    const auto isNear = [&](const LocatedPart& other) {
      const double apart =
          (fromMsg(part.pose.pose).translation() - fromMsg(other.pose.pose).translation()).norm();
      return apart > 0.0 && apart < kReach;
    };
    const auto& refused = response().refused;
    return std::none_of(parts.begin(), parts.end(), isNear) &&
           std::none_of(refused.begin(), refused.end(),
                        [&](const auto& entry) { return isNear(entry.located); });
  };
  ASSERT_FALSE(parts.empty());
  EXPECT_GE(parts.front().visible_fraction, kFree);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t k = i + 1; k < parts.size(); ++k) {
      if (isAlone(parts[k])) {
        EXPECT_GE(merit(parts[i]) + 1e-6, merit(parts[k]));
      }
    }
    EXPECT_GE(parts[i].score, 0.0);
    EXPECT_LE(parts[i].score, 1.0);
    EXPECT_NE(parts[i].child_frame.find(parts[i].part + "_"), std::string::npos);
    EXPECT_GT(parts[i].pose.covariance[0], 0.0);
  }
}

// At the latest time, that is, also after the camera has moved on.
TEST_F(Locate, FramesStandOnTf) {
  for (const LocatedPart& part : response().parts) {
    const auto T_header_part = lookup(part.header.frame_id, part.child_frame, ros::Time());
    ASSERT_TRUE(T_header_part) << part.child_frame;
    EXPECT_TRUE(isometryNear(*T_header_part, fromMsg(part.pose.pose), 1e-9, 1e-6));
  }
}

TEST_F(Locate, LatchedTopicsShowTheAnswer) {
  const auto list = latched<LocatedParts>("located_parts");
  ASSERT_TRUE(list);
  EXPECT_EQ(list->parts.size(), response().parts.size());
  const auto markers = latched<visualization_msgs::MarkerArray>("markers");
  ASSERT_TRUE(markers);
  std::map<std::string, std::size_t> shown;
  for (const auto& marker : markers->markers) ++shown[marker.ns];
  for (const char* what : {"solid", "outline", "name"})
    EXPECT_EQ(shown[what], response().parts.size()) << what;
  const auto overlay = latched<sensor_msgs::Image>("overlay");
  ASSERT_TRUE(overlay);
  EXPECT_EQ(overlay->encoding, "bgr8");
  EXPECT_GT(overlay->width, 0u);
}

}  // namespace
}  // namespace planar_bin_picking_ros

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "locate_tester");
  ros::AsyncSpinner spinner(1);
  spinner.start();
  return RUN_ALL_TESTS();
}
