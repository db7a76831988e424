// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick_policy.h"

#include "support/matchers.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846;

Eigen::Isometry3d downAt(double x, double y, double z, double lean_deg = 0.0) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, y, z);
  T.linear() = (Eigen::AngleAxisd(lean_deg * kPi / 180.0, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return T;
}

PickCandidate candidateAt(double x, double y) {
  PickCandidate candidate;
  candidate.part = "bracket";
  candidate.center = Eigen::Vector3d(x, y, 0.01);
  candidate.score = 0.9;
  candidate.visible_fraction = 1.0;
  candidate.tilt_deg = 5.0;
  candidate.T_target_pick = {downAt(x, y, 0.01)};
  candidate.surroundings = cv::Mat(24, 24, CV_32F, cv::Scalar(0));
  return candidate;
}

PickBin binOf400x300() {
  PickBin bin;
  bin.min = Eigen::Vector3d(-0.2, -0.15, 0.0);
  bin.max = Eigen::Vector3d(0.2, 0.15, 0.1);
  return bin;
}

std::vector<std::size_t> order(const PickPlan& plan) {
  std::vector<std::size_t> indices;
  for (const auto& offer : plan.offers) indices.push_back(offer.candidate);
  return indices;
}

using Order = std::vector<std::size_t>;

TEST(PickPolicy, OffersInRankByDefault) {
  PickPolicy policy{PickParams()};
  const auto plan =
      policy.plan({candidateAt(0, 0), candidateAt(0.1, 0), candidateAt(0.19, 0)}, binOf400x300());
  EXPECT_EQ(order(plan), Order({0, 1, 2}));
  EXPECT_TRUE(plan.refused.empty());
}

TEST(PickPolicy, RefusesEachWithItsReason) {
  PickParams params;
  params.score_min = 0.8, params.visible_min = 0.9, params.tilt_max_deg = 30.0;
  params.tool_radius = 0.015;
  PickPolicy policy(params);
  std::vector<PickCandidate> candidates(5, candidateAt(0, 0));
  candidates[0].score = 0.7;
  candidates[1].visible_fraction = 0.8;
  candidates[2].tilt_deg = 31.0;
  candidates[3] = candidateAt(0.19, 0);
  const auto plan = policy.plan(candidates, binOf400x300());
  EXPECT_EQ(order(plan), Order({4}));
  ASSERT_EQ(plan.refused.size(), 4u);
  EXPECT_EQ(plan.refused[0].reason, PickRefusal::kLowScore);
  EXPECT_EQ(plan.refused[1].reason, PickRefusal::kOccluded);
  EXPECT_EQ(plan.refused[2].reason, PickRefusal::kTilt);
  EXPECT_EQ(plan.refused[3].reason, PickRefusal::kWall);
  EXPECT_NE(plan.refused[2].text.find("31.0"), std::string::npos);
}

TEST(PickPolicy, KeepsThePickPosesThatTheToolCanReach) {
  PickParams params;
  params.tool_radius = 0.015;
  PickPolicy policy(params);
  PickCandidate candidate = candidateAt(0.15, 0);
  candidate.T_target_pick = {downAt(0.19, 0, 0.01), downAt(0.13, 0, 0.01)};
  const auto plan = policy.plan({candidate}, binOf400x300());
  ASSERT_EQ(plan.offers.size(), 1u);
  EXPECT_EQ(plan.offers[0].picks, Order({1}));
}

TEST(PickPolicy, LeavesOutPickPosesThatSomethingCovers) {
  PickParams params;
  params.tool_radius = 0.01;
  PickPolicy policy(params);
  PickCandidate candidate = candidateAt(0, 0);
  candidate.T_target_pick = {downAt(0, 0, 0.01), downAt(0.05, 0, 0.01)};
  candidate.face.T_target_part.translation() = Eigen::Vector3d(0.02, 0.0, 0.01);
  candidate.face.cell_size = 0.002;
  candidate.face.covered = {{-0.012, 0.003}};  // 8.5 mm beside the first pick
  const auto plan = policy.plan({candidate}, std::nullopt);
  ASSERT_EQ(plan.offers.size(), 1u);
  EXPECT_EQ(plan.offers[0].picks, std::vector<std::size_t>({1}));
  candidate.face.covered.emplace_back(0.03, 0.0);
  const auto none = policy.plan({candidate}, binOf400x300());
  ASSERT_EQ(none.refused.size(), 1u);
  EXPECT_EQ(none.refused[0].reason, PickRefusal::kOccluded);
  EXPECT_NE(none.refused[0].text.find("0.010 m"), std::string::npos) << none.refused[0].text;
  params.tool_radius = 0.0;  // nothing is known about the tool
  EXPECT_EQ(PickPolicy(params).plan({candidate}, std::nullopt).offers.size(), 1u);
}

TEST(PickPolicy, LooksAtTheWholeShaft) {
  PickParams params;
  params.tool_radius = 0.01;
  PickPolicy policy(params);
  PickCandidate inward = candidateAt(0.17, 0), outward = inward;
  inward.T_target_pick = {downAt(0.17, 0, 0.01, -20.0)};
  outward.T_target_pick = {downAt(0.17, 0, 0.01, 20.0)};  // its shaft leans over to the wall
  const auto plan = policy.plan({inward, outward}, binOf400x300());
  EXPECT_EQ(order(plan), Order({0}));
  EXPECT_EQ(policy.plan({outward}, std::nullopt).offers.size(), 1u);
}

TEST(PickPolicy, AToolMayEndBelowTheWallsTop) {
  PickParams params;
  params.tool_radius = 0.01;
  PickCandidate outward = candidateAt(0.17, 0);
  outward.T_target_pick = {downAt(0.17, 0, 0.01, 20.0)};  // 3 cm up it is still clear of the wall
  EXPECT_TRUE(PickPolicy(params).plan({outward}, binOf400x300()).offers.empty());
  params.tool_height = 0.03;
  EXPECT_EQ(PickPolicy(params).plan({outward}, binOf400x300()).offers.size(), 1u);
}

TEST(PickPolicy, APartsOwnToolComesFirst) {
  PickParams params;
  params.tool_radius = 0.01;
  PickCandidate thin = candidateAt(0.18, 0), wide = thin, high = candidateAt(0.17, 0);
  wide.tool.radius = 0.03;
  high.T_target_pick = {downAt(0.17, 0, 0.01, 20.0)};
  PickCandidate low = high;
  low.tool.height = 0.03;
  PickPolicy policy(params);
  const auto plan = policy.plan({thin, wide, high, low}, binOf400x300());
  EXPECT_EQ(order(plan), Order({0, 3}));
  EXPECT_NE(plan.refused.at(0).text.find("0.030"), std::string::npos);
  // Also where the parameters look at no walls, and the other way round.
  EXPECT_EQ(order(PickPolicy(PickParams()).plan({thin, wide}, binOf400x300())), Order({0}));
  thin = candidateAt(0.195, 0);
  thin.tool.radius = 0.0;
  EXPECT_EQ(policy.plan({thin}, binOf400x300()).offers.size(), 1u);
}

TEST(PickPolicy, OffersAFailedInstanceLast) {
  PickPolicy policy{PickParams()};
  const std::vector<PickCandidate> candidates = {candidateAt(0, 0), candidateAt(0.1, 0)};
  policy.fail(candidates[0]);
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt)), Order({1, 0}));
  policy.fail(candidates[0]);
  const auto plan = policy.plan(candidates, std::nullopt);
  EXPECT_EQ(order(plan), Order({1}));
  ASSERT_EQ(plan.refused.size(), 1u);
  EXPECT_EQ(plan.refused[0].reason, PickRefusal::kFailedBefore);
  // Found a little elsewhere in the next image: the same instance.
  std::vector<PickCandidate> again = {candidateAt(0.001, 0)};
  EXPECT_TRUE(policy.plan(again, std::nullopt).offers.empty());
}

TEST(PickPolicy, ForgetsAFailureOnceTheSceneHasChanged) {
  PickPolicy policy{PickParams()};
  std::vector<PickCandidate> candidates = {candidateAt(0, 0), candidateAt(0.1, 0)};
  policy.fail(candidates[0]);
  candidates[0].surroundings = cv::Mat(24, 24, CV_32F, cv::Scalar(3));  // noise, a lamp that ages
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt)), Order({1, 0}));
  candidates[0].surroundings = cv::Mat(24, 24, CV_32F, cv::Scalar(40));
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt)), Order({0, 1}));
  candidates[0].surroundings = cv::Mat(24, 24, CV_32F, cv::Scalar(3));
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt)), Order({0, 1}));  // forgotten for good
}

TEST(PickPolicy, ForgetsAFailureAfterASuccess) {
  PickPolicy policy{PickParams()};
  const std::vector<PickCandidate> candidates = {candidateAt(0, 0), candidateAt(0.1, 0)};
  policy.fail(candidates[0]);
  policy.succeed(candidates[0]);
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt)), Order({0, 1}));
}

TEST(PickPolicy, RefusesParamsOutOfRange) {
  PickParams params;
  params.visible_min = 1.5;
  EXPECT_TRUE(refuses([&] { PickPolicy policy(params); }, {"visible_min is 1.5", "0 .. 1"}));
}

TEST(CutSurroundings, ChangesWithTheSceneAndNotWithTheLamp) {
  Camera::Model model;
  model.width = 640, model.height = 480, model.fx = model.fy = 800.0, model.cx = 320.0,
  model.cy = 240.0;
  const Camera camera(model);
  cv::Mat grey(480, 640, CV_8U, cv::Scalar(90));
  grey(cv::Rect(300, 220, 40, 40)).setTo(150);
  const Eigen::Isometry3d T = downAt(0, 0, 0.8);
  const auto cut = [&](const cv::Mat& image) {
    return cutSurroundings(image, camera, T, Eigen::Vector3d::Zero(), 0.08);
  };
  const cv::Mat before = cut(grey);
  ASSERT_FALSE(before.empty());
  EXPECT_LT(cv::norm(before, cut(grey + 20), cv::NORM_L1) / before.total(), 0.5);
  grey(cv::Rect(345, 180, 30, 120)).setTo(150);
  EXPECT_GT(cv::norm(before, cut(grey), cv::NORM_L1) / before.total(), 12.0);
  EXPECT_TRUE(
      cutSurroundings(grey, camera, downAt(0.3, 0, 0.8), Eigen::Vector3d::Zero(), 0.08).empty());
}

TEST(DeadlockHint, GoesByTheMostFrequentReason) {
  const auto refused = [](PickRefusal reason) { return Refused{0, reason, ""}; };
  const auto hint = deadlockHint(
      {refused(PickRefusal::kTilt), refused(PickRefusal::kWall), refused(PickRefusal::kWall)});
  EXPECT_NE(hint.find("2 of 3"), std::string::npos);
  EXPECT_NE(hint.find("wall"), std::string::npos);
}

}  // namespace
}  // namespace planar_bin_picking
