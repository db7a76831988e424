// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/tool_room.h"

#include "planar_bin_picking/pick/pick_policy.h"
#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

/// Two fingers of 10 x 20 mm, 50 mm apart, that reach 5 mm beside the part, 60 mm long.
const std::vector<double> kFingers = {-0.035, -0.01, -0.055, -0.025, 0.01, 0.005,
                                      0.025,  -0.01, -0.055, 0.035,  0.01, 0.005};

/// A plate of 40 x 20 mm, 3 mm thick, about its origin.
std::shared_ptr<const PartModel> plate() {
  sim::Plate plate{rectangle(-20, -10, 20, 10), {circle(0, 0, 4, true)}, {}, 3.0};
  return makePart("plate", plate);
}

/// Straight down.
Eigen::Isometry3d downAt(double x, double y, double z) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX());
}

Eigen::Isometry3d lyingAt(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

PickCandidate candidateAt(double x) {
  PickCandidate candidate;
  candidate.part = "plate";
  candidate.model = plate();
  candidate.center = Eigen::Vector3d(x, 0, 0.003);
  candidate.score = candidate.visible_fraction = 1.0;
  candidate.T_target_pick = {downAt(x, 0, 0.003)};
  candidate.face.T_target_part = lyingAt(x, 0, 0.003);
  return candidate;
}

TEST(ToolRoom, ReadsBoxesAndCylinders) {
  const auto bodies = toolBodies(kFingers, {0.0, 0.1, 0.02, -0.05, 0.0});
  ASSERT_EQ(bodies.size(), 3u);
  EXPECT_EQ(bodies[1].high, 0.005);
  for (const Eigen::Vector2d& p : bodies[2].footprint)
    EXPECT_GE((p - Eigen::Vector2d(0.0, 0.1)).norm(), 0.02);
  EXPECT_TRUE(toolBodies({}, {}).empty());
  EXPECT_TRUE(refuses([] { toolBodies({1, 2, 3}, {}); }, {"tool_boxes", "3 numbers"}));
  EXPECT_TRUE(refuses([] { toolBodies({0, 0, 0, 0.1, 0.1, -0.1}, {}); }, {"tool_boxes", "lesser"}));
  EXPECT_TRUE(refuses([] { toolBodies({0, 0, 0, 10, 10, 10}, {}); }, {"beyond 1 m"}));
  EXPECT_TRUE(refuses([] { toolBodies({0, 0, 0, NAN, 0.1, 0.1}, {}); }, {"tool_boxes"}));
  EXPECT_TRUE(refuses([] { toolBodies({}, {0, 0, 0, -0.1, 0}); }, {"tool_cylinders", "radius"}));
  PickParams params;
  params.tool_boxes = {1};
  EXPECT_TRUE(refuses([&] { PickPolicy{params}; }, {"tool_boxes"}));
}

TEST(ToolRoom, FingersNeedRoomBesideThePart) {
  const auto fingers = toolBodies(kFingers, {});
  const auto touches = [&](const Eigen::Isometry3d& T_target_part, double clearance = 0.0,
                           double approach = 0.0) {
    return touchesPart({fingers, downAt(0, 0, 0.003), approach, clearance},
                       {plate(), T_target_part});
  };
  EXPECT_FALSE(touches(lyingAt(0, 0, 0.003)));      // the part between them
  EXPECT_TRUE(touches(lyingAt(0.05, 0, 0.003)));    // beside it, under a finger
  EXPECT_FALSE(touches(lyingAt(0.056, 0, 0.003)));  // 1 mm beside the finger
  EXPECT_TRUE(touches(lyingAt(0.056, 0, 0.003), 0.002));
  EXPECT_FALSE(touches(lyingAt(0.05, 0, -0.003)));  // 1 mm below the finger
  EXPECT_TRUE(touches(lyingAt(0.05, 0, -0.003), 0.002));
  EXPECT_TRUE(touches(lyingAt(0.05, 0, 0.05)));             // high up, at the shaft
  EXPECT_FALSE(touches(lyingAt(0.05, 0, 0.09)));            // above it
  EXPECT_TRUE(touches(lyingAt(0.05, 0, 0.09), 0.0, 0.05));  // but on the way
  // A steep one that leans into the finger, and one that leans away from it.
  const Eigen::AngleAxisd steep(80.0 * kDegrees, Eigen::Vector3d::UnitY());
  EXPECT_TRUE(touches(lyingAt(0.03, 0, 0.02) * steep));
  EXPECT_FALSE(touches(lyingAt(0.045, 0, 0.02) * steep));
}

TEST(ToolRoom, AHoleIsRoom) {
  const auto pin = toolBodies({}, {0.0, 0.0, 0.002, -0.05, 0.01});
  EXPECT_FALSE(touchesPart({pin, downAt(0, 0, 0.003), 0.0, 0.0}, {plate(), lyingAt(0, 0, 0.003)}));
  EXPECT_TRUE(
      touchesPart({pin, downAt(0.01, 0, 0.003), 0.0, 0.0}, {plate(), lyingAt(0, 0, 0.003)}));
  EXPECT_TRUE(
      touchesPart({pin, downAt(0.003, 0, 0.003), 0.0, 0.0}, {plate(), lyingAt(0, 0, 0.003)}));
}

TEST(ToolRoom, ThePartItselfHasToFitBetweenTheFingers) {
  const auto part = plate();
  const Eigen::Isometry3d along = downAt(0, 0, 0);
  const Eigen::Isometry3d across =
      along * Eigen::AngleAxisd(0.5 * EIGEN_PI, Eigen::Vector3d::UnitZ());
  EXPECT_FALSE(touchesOwnPart(toolBodies(kFingers, {}), *part, along));  // opened by 50 mm
  const std::vector<double> narrow = {-0.02, -0.01, -0.055, -0.012, 0.01, 0.005,
                                      0.012, -0.01, -0.055, 0.02,   0.01, 0.005};
  EXPECT_TRUE(touchesOwnPart(toolBodies(narrow, {}), *part, along));    // by 24 mm, for 40
  EXPECT_FALSE(touchesOwnPart(toolBodies(narrow, {}), *part, across));  // for 20
  const auto cup = toolBodies({}, {0.012, 0.0, 0.004, -0.05, 0.001});
  EXPECT_FALSE(touchesOwnPart(cup, *part, along));  // pressed on by a millimetre
  // The policy leaves such a pick pose out, and says why where no other is left.
  PickParams params;
  params.tool_boxes = narrow;
  PickPolicy policy(params);
  PickCandidate candidate = candidateAt(0.0);
  const auto refused = policy.plan({candidate}, std::nullopt).refused;
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_EQ(refused[0].reason, PickRefusal::kNoRoom);
  EXPECT_NE(refused[0].text.find("the part itself"), std::string::npos) << refused[0].text;
  candidate.T_target_pick.push_back(candidate.T_target_pick[0] * along.inverse() * across);
  const auto turned = policy.plan({candidate}, std::nullopt);
  ASSERT_EQ(turned.offers.size(), 1u);
  EXPECT_EQ(turned.offers[0].picks, std::vector<std::size_t>{1});
}

TEST(ToolRoom, WallsAndFloorBarIt) {
  PickBin bin;
  bin.min = Eigen::Vector3d(-0.2, -0.15, 0.0);
  bin.max = Eigen::Vector3d(0.2, 0.15, 0.04);
  const auto fingers = toolBodies(kFingers, {});
  const auto touches = [&](const Eigen::Isometry3d& T, double clearance = 0.0,
                           double approach = 0.0) {
    return touchesBin({fingers, T, approach, clearance}, bin);
  };
  EXPECT_FALSE(touches(downAt(0, 0, 0.01)));
  EXPECT_TRUE(touches(downAt(0, 0, 0.002)));  // 3 mm into the floor
  EXPECT_FALSE(touches(downAt(0.16, 0, 0.01)));
  EXPECT_TRUE(touches(downAt(0.17, 0, 0.01)));
  EXPECT_TRUE(touches(downAt(0.16, 0, 0.01), 0.006));
  EXPECT_FALSE(touches(downAt(0.17, 0, 0.05)));  // above the wall
  // Leaning over the wall, only its way from far up leads through it.
  const auto leaning = [](double x, double z) {
    return Eigen::Isometry3d(Eigen::Translation3d(x, 0.0, z) *
                             Eigen::AngleAxisd(30.0 * kDegrees, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()));
  };
  const auto short_rod = toolBodies({}, {0.0, 0.0, 0.005, -0.01, 0.0});
  EXPECT_FALSE(touchesBin({short_rod, leaning(0.185, 0.01), 0.0, 0.0}, bin));
  EXPECT_TRUE(touchesBin({short_rod, leaning(0.185, 0.01), 0.02, 0.0}, bin));
}

TEST(ToolRoom, TheWayFromTheApproachIsLookedAt) {
  PickParams params;
  params.tool_radius = 0.005, params.tool_height = 0.01;
  PickPolicy policy(params);
  PickBin bin;
  bin.min = Eigen::Vector3d(-0.2, -0.15, 0.0);
  bin.max = Eigen::Vector3d(0.2, 0.15, 0.1);
  PickCandidate leaning = candidateAt(0.17);
  leaning.T_target_pick = {
      Eigen::Translation3d(0.17, 0.0, 0.01) *
      Eigen::AngleAxisd(30.0 * kDegrees, Eigen::Vector3d::UnitY()) *
      Eigen::Isometry3d(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()))};
  EXPECT_EQ(policy.plan({leaning}, bin).offers.size(), 1u);
  leaning.approach = 0.08;  // from there it would come through the wall
  const auto plan = policy.plan({leaning}, bin);
  ASSERT_EQ(plan.refused.size(), 1u);
  EXPECT_EQ(plan.refused[0].reason, PickRefusal::kWall);
}

TEST(ToolRoom, ThePolicyLeavesOutPicksWithoutRoom) {
  PickParams params;
  params.tool_boxes = kFingers;
  PickPolicy policy(params);
  const auto plan =
      policy.plan({candidateAt(0.0), candidateAt(0.05), candidateAt(0.2)}, std::nullopt);
  ASSERT_EQ(plan.offers.size(), 1u);
  EXPECT_EQ(plan.offers[0].candidate, 2u);
  ASSERT_EQ(plan.refused.size(), 2u);
  EXPECT_EQ(plan.refused[0].reason, PickRefusal::kNoRoom);
  EXPECT_NE(deadlockHint(plan.refused).find("no room"), std::string::npos);
  PickCandidate other_way = candidateAt(0.0);  // across, there is room
  other_way.T_target_pick.push_back(other_way.T_target_pick[0] *
                                    Eigen::AngleAxisd(0.5 * EIGEN_PI, Eigen::Vector3d::UnitZ()));
  const auto turned = policy.plan({other_way, candidateAt(0.05)}, std::nullopt);
  ASSERT_EQ(turned.offers.size(), 1u);
  EXPECT_EQ(turned.offers[0].picks, std::vector<std::size_t>{1});
  PickCandidate strange = candidateAt(0.2);
  strange.strange_edges = {0.006};
  EXPECT_EQ(policy.plan({strange}, std::nullopt).refused.at(0).reason, PickRefusal::kNoRoom);
  params.tool_edges = 0.007;
  EXPECT_TRUE(PickPolicy(params).plan({strange}, std::nullopt).refused.empty());
  params.tool_edges = 0.0;
  EXPECT_TRUE(PickPolicy(params).plan({strange}, std::nullopt).refused.empty());
}

TEST(ToolRoom, EdgesThatNobodyExplainsAreThoseOfOthers) {
  const auto bracket = makePart("bracket", bracketPlate());
  sim::Scene scene = sceneOf(bracketPlate(), {0, 0, 600, 0});
  const Eigen::Isometry3d T_camera_part = scene.plates[0].T_camera_part;
  scene.plates.push_back({{rectangle(-8, -8, 8, 8), {}, {}, 0.0}, sim::poseOf({30, -20, 600, 20})});
  const Shot shot = shoot(scene);
  const StrangeEdges edges(shot.image, shot.camera, {{bracket, T_camera_part}});
  const auto pad = toolBodies({}, {0.0, 0.0, 0.012, -0.05, 0.0});
  const auto at = [&](double x, double y) {
    return edges.below(pad, Eigen::Isometry3d(Eigen::Translation3d(x, y, 0.6)));
  };
  EXPECT_LT(at(0.0, 0.01), 0.004);     // the bracket's own edges
  EXPECT_LT(at(-0.03, 0.07), 0.004);   // nothing at all
  EXPECT_GT(at(0.030, -0.020), 0.03);  // the other one's four sides
  const auto palm = toolBodies({-0.012, -0.012, -0.08, 0.012, 0.012, -0.04}, {});
  EXPECT_EQ(edges.below(palm, Eigen::Isometry3d(Eigen::Translation3d(0.030, -0.020, 0.6))), 0.0);
  const StrangeEdges unknown(shot.image, shot.camera, {});
  EXPECT_GT(unknown.below(pad, Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.01, 0.6))), 0.01);
}

}  // namespace
}  // namespace planar_bin_picking
