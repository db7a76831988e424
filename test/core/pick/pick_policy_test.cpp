// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/pick_policy.h"

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
  candidate.score = candidate.confirmed = 0.9;
  candidate.visible_fraction = 1.0;
  candidate.tilt_deg = 5.0;
  candidate.T_target_pick = {downAt(x, y, 0.01)};
  candidate.surroundings = {cv::Mat(24, 24, CV_32F, cv::Scalar(0)), 8};
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
  params.tool_radius = 0.01, params.tilt_max_deg = 30.0;
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
  candidate.tilt_deg = 31.0;  // is told after what covers it
  const auto none = policy.plan({candidate}, binOf400x300());
  ASSERT_EQ(none.refused.size(), 1u);
  EXPECT_EQ(none.refused[0].reason, PickRefusal::kOccluded);
  EXPECT_NE(none.refused[0].text.find("0.010 m"), std::string::npos) << none.refused[0].text;
  // Nothing is known about the tool.
  EXPECT_EQ(PickPolicy(PickParams()).plan({candidate}, std::nullopt).offers.size(), 1u);
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

// The walls' top is at 0.1 m: of a part just below it little of the shaft is beside them.
TEST(PickPolicy, AShaftIsFreeAboveTheWalls) {
  PickParams params;
  params.tool_radius = 0.01;
  PickPolicy policy(params);
  const auto offered = [&](double x, double z) {
    PickCandidate candidate = candidateAt(x, 0);
    candidate.T_target_pick = {downAt(x, 0, z, 20.0)};
    return !policy.plan({candidate}, binOf400x300()).offers.empty();
  };
  EXPECT_TRUE(offered(0.182, 0.08));  // 2 cm up it leans 7.3 mm over
  EXPECT_FALSE(offered(0.184, 0.08));
  EXPECT_TRUE(offered(0.189, 0.102));  // wholly above
  EXPECT_FALSE(offered(0.191, 0.102));
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
  candidates[0].surroundings.patch =
      cv::Mat(24, 24, CV_32F, cv::Scalar(3));  // noise, a lamp that ages
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt)), Order({1, 0}));
  candidates[0].surroundings.patch = cv::Mat(24, 24, CV_32F, cv::Scalar(40));
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt)), Order({0, 1}));
  candidates[0].surroundings.patch = cv::Mat(24, 24, CV_32F, cv::Scalar(3));
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt)), Order({0, 1}));  // forgotten for good
}

// A 12-bit camera: 12 levels of 256 are 192 of its own.
TEST(PickPolicy, CountsAChangeInLevelsOfEightBits) {
  PickPolicy policy{PickParams()};
  PickCandidate candidate = candidateAt(0, 0);
  candidate.surroundings.bits = 12;
  policy.fail(candidate);
  candidate.surroundings.patch = cv::Mat(24, 24, CV_32F, cv::Scalar(190));
  EXPECT_EQ(policy.plan({candidate}, std::nullopt).offers.at(0).failures, 1);
  candidate.surroundings.patch = cv::Mat(24, 24, CV_32F, cv::Scalar(195));
  EXPECT_EQ(policy.plan({candidate}, std::nullopt).offers.at(0).failures, 0);
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

// What was asked for, the bin's box, the pick poses, the parameters: the first that bars it tells
// why.
TEST(PickPolicy, TellsTheFirstRuleThatIsBroken) {
  PickParams params;
  params.score_min = 0.95, params.tool_radius = 0.02;
  PickPolicy policy(params);
  PickCandidate candidate = candidateAt(0.3, 0);
  candidate.other_picks = "rim (front)";
  candidate.withheld = PickRefusal::kWrongFace;
  candidate.withheld_text = "its back is up";
  const auto reason = [&] {
    const auto plan = policy.plan({candidate}, binOf400x300());
    EXPECT_TRUE(plan.offers.empty());
    return plan.refused.at(0);
  };
  EXPECT_EQ(reason().reason, PickRefusal::kWrongFace);
  EXPECT_EQ(reason().text, "its back is up");
  candidate.withheld.reset();
  EXPECT_EQ(reason().reason, PickRefusal::kOutside);
  EXPECT_NE(reason().text.find("0.100 m outside of the bin's box along x"), std::string::npos)
      << reason().text;
  candidate.center.x() = 0.0;
  EXPECT_EQ(reason().reason, PickRefusal::kNoPickPose);
  EXPECT_NE(reason().text.find("rim (front)"), std::string::npos);
  candidate.other_picks.clear();
  EXPECT_EQ(reason().reason, PickRefusal::kLowScore);
  candidate.score = 0.96;
  EXPECT_EQ(reason().reason, PickRefusal::kWall);
}

TEST(PickPolicy, OffersNothingOutsideOfTheBinsBox) {
  PickPolicy policy{PickParams()};
  PickBin bin = binOf400x300();
  const auto offered = [&](double x, double y, double z) {
    PickCandidate candidate = candidateAt(x, y);
    candidate.center.z() = z;
    return !policy.plan({candidate}, bin).offers.empty();
  };
  EXPECT_TRUE(offered(0.204, 0.154, 0.104));
  EXPECT_TRUE(offered(-0.204, -0.154, -0.004));
  EXPECT_FALSE(offered(0.206, 0, 0.05));
  EXPECT_FALSE(offered(-0.206, 0, 0.05));
  EXPECT_FALSE(offered(0, 0.156, 0.05));
  EXPECT_FALSE(offered(0, -0.156, 0.05));
  EXPECT_FALSE(offered(0, 0, 0.106));
  EXPECT_FALSE(offered(0, 0, -0.006));
  // The box is the bin's, wherever that stands in the frame of the answers.
  bin.T_bin_target.translation().x() = -0.5;
  EXPECT_TRUE(offered(0.5, 0, 0.05));
  EXPECT_FALSE(offered(0, 0, 0.05));
  EXPECT_FALSE(policy.plan({candidateAt(9.0, 0)}, std::nullopt).offers.empty());
}

TEST(PickPolicy, AllowsForHowWellThePositionIsKnown) {
  EXPECT_DOUBLE_EQ(boxMargin(0.0), 0.005);
  EXPECT_DOUBLE_EQ(boxMargin(0.002), 0.011);
  EXPECT_DOUBLE_EQ(boxMargin(0.5), 0.02);
  PickPolicy policy{PickParams()};
  PickBin bin = binOf400x300();
  PickCandidate candidate = candidateAt(0.21, 0);
  candidate.center_covariance.diagonal() << 4e-6, 0.0, 0.0;
  EXPECT_EQ(policy.plan({candidate}, bin).offers.size(), 1u);
  candidate.center_covariance.diagonal() << 0.0, 4e-6, 4e-6;  // not in the direction that matters
  EXPECT_TRUE(policy.plan({candidate}, bin).offers.empty());
  bin.T_bin_target.linear() =
      Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  candidate.center = Eigen::Vector3d(0.0, -0.21, 0.05);  // x of the bin is -y of the target frame
  EXPECT_EQ(policy.plan({candidate}, bin).offers.size(), 1u);
}

TEST(PickPolicy, CutsByNumberLast) {
  PickPolicy policy{PickParams()};
  const std::vector<PickCandidate> candidates = {candidateAt(0, 0), candidateAt(0.1, 0),
                                                 candidateAt(0.1, 0.1), candidateAt(0, 0.1)};
  policy.fail(candidates[0]);
  policy.fail(candidates[0]);
  policy.fail(candidates[1]);
  auto plan = policy.plan(candidates, std::nullopt, 2);
  EXPECT_EQ(order(plan), Order({2, 3}));
  ASSERT_EQ(plan.refused.size(), 2u);
  EXPECT_EQ(plan.refused[0].candidate, 0u);
  EXPECT_EQ(plan.refused[0].reason, PickRefusal::kFailedBefore);
  EXPECT_EQ(plan.refused[1].candidate, 1u);
  EXPECT_EQ(plan.refused[1].reason, PickRefusal::kBeyondMaxParts);
  EXPECT_EQ(plan.refused[1].text, "its rank is 3, max_parts is 2");
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt, 3)), Order({2, 3, 1}));
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt, 9)), Order({2, 3, 1}));
  EXPECT_EQ(order(policy.plan(candidates, std::nullopt, 0)), Order({2, 3, 1}));
}

TEST(PickPolicy, EachLimitIsAllowedItself) {
  PickParams params;
  params.score_min = 0.9, params.visible_min = 1.0, params.tilt_max_deg = 5.0;
  params.failures_max = 1;
  PickPolicy policy(params);
  EXPECT_EQ(policy.plan({candidateAt(0, 0)}, std::nullopt).offers.size(), 1u);
  policy.fail(candidateAt(0, 0));
  const auto plan = policy.plan({candidateAt(0, 0)}, std::nullopt);
  ASSERT_EQ(plan.refused.size(), 1u);
  EXPECT_EQ(plan.refused[0].text, "1 picks or looks failed here, and the scene is as it was");
}

TEST(PickPolicy, AFailureIsThatOfOnePartAtOnePlace) {
  PickPolicy policy{PickParams()};
  policy.fail(candidateAt(0, 0));
  PickCandidate other = candidateAt(0, 0);
  other.part = "gasket";
  EXPECT_EQ(order(policy.plan({candidateAt(0.0031, 0), candidateAt(0, 0)}, std::nullopt)),
            Order({0, 1}));
  EXPECT_EQ(order(policy.plan({candidateAt(0.0029, 0), candidateAt(0.1, 0)}, std::nullopt)),
            Order({1, 0}));
  EXPECT_EQ(policy.plan({other}, std::nullopt).offers.at(0).failures, 0);
  EXPECT_EQ(policy.plan({candidateAt(0, 0)}, std::nullopt).offers.at(0).failures, 1);
}

TEST(PickPolicy, ChangeIsHeldAgainstTheLatestFailure) {
  PickPolicy policy{PickParams()};
  PickCandidate candidate = candidateAt(0, 0);
  const auto grey = [&](double level) {
    candidate.surroundings.patch = cv::Mat(24, 24, CV_32F, cv::Scalar(level));
    return candidate;
  };
  policy.fail(grey(0));
  policy.fail(grey(10));
  EXPECT_TRUE(policy.plan({grey(22)}, std::nullopt).offers.empty());  // the limit itself is none
  candidate.surroundings.patch = cv::Mat();                           // nothing tells of a change
  EXPECT_TRUE(policy.plan({candidate}, std::nullopt).offers.empty());
  EXPECT_EQ(policy.plan({grey(22.5)}, std::nullopt).offers.size(), 1u);
}

TEST(PickPolicy, AWallIsTouchedOnEachSide) {
  PickParams params;
  params.tool_radius = 0.01, params.wall_clearance = 0.005;
  PickPolicy policy(params);
  const auto offered = [&](double x, double y) {
    return !policy.plan({candidateAt(x, y)}, binOf400x300()).offers.empty();
  };
  EXPECT_TRUE(offered(0.184, 0.134) && offered(-0.184, -0.134));
  EXPECT_FALSE(offered(0.186, 0) || offered(-0.186, 0) || offered(0, 0.136) || offered(0, -0.136));
}

// A tool that stands on the part the wrong way round would have to come through the bin's floor.
TEST(PickPolicy, AToolFromBelowIsHeldAgainstTheWallsWhereItStands) {
  PickParams params;
  params.tool_radius = 0.01;
  PickPolicy policy(params);
  PickCandidate upward = candidateAt(0.17, 0);
  upward.T_target_pick = {downAt(0.17, 0, 0.01, 160.0)};
  EXPECT_EQ(policy.plan({upward}, binOf400x300()).offers.size(), 1u);
}

TEST(DeadlockHint, TellsOfEachReasonTheMostFrequentFirst) {
  const auto refused = [](PickRefusal reason) { return Refused{0, reason, ""}; };
  const auto hint = deadlockHint(
      {refused(PickRefusal::kTilt), refused(PickRefusal::kWall), refused(PickRefusal::kWall)});
  const auto wall = hint.find("2 of 3 lie at the wall"), steep = hint.find("1 of 3 lie too steep");
  EXPECT_EQ(wall, 0u) << hint;
  EXPECT_NE(steep, std::string::npos) << hint;
  EXPECT_EQ(deadlockHint({}), "nothing was found");
}

TEST(DeadlockHint, HasARemedyForEachReason) {
  const std::pair<PickRefusal, const char*> words[] = {
      {PickRefusal::kLowScore, "pick/score_min"},  {PickRefusal::kOccluded, "pick/visible_min"},
      {PickRefusal::kTilt, "pick/tilt_max_deg"},   {PickRefusal::kWall, "thinner tool"},
      {PickRefusal::kFailedBefore, "gripper"},     {PickRefusal::kOutside, "the cell's file"},
      {PickRefusal::kNoPickPose, "no pick pose"},  {PickRefusal::kWrongFace, "other face"},
      {PickRefusal::kBeyondMaxParts, "max_parts"},
  };
  for (const auto& [reason, word] : words) {
    const auto hint = deadlockHint({Refused{0, reason, ""}});
    EXPECT_NE(hint.find(word), std::string::npos) << hint;
  }
}

}  // namespace
}  // namespace planar_bin_picking
