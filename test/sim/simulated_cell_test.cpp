// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/simulated_cell.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include <cmath>

namespace planar_bin_picking::cell {
namespace {

constexpr double kPi = 3.14159265358979323846;
const std::string kParts = std::string(PACKAGE_DIR) + "/test/data/parts/";
constexpr double kThickness = 0.002;  // of the hinge

Eigen::Isometry3d at(double x, double y, double z) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

Eigen::Isometry3d overhead() {
  return at(0.0, 0.0, 0.75) * Eigen::Isometry3d(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
}

CellConfig smallCell(int count) {
  CellConfig config;
  config.suction.load_max = 0.3;  // a part of the same kind that leans on it is enough
  config.lens.width = 320, config.lens.height = 256;
  config.lens.fx = config.lens.fy = 420.0, config.lens.cx = 159.5, config.lens.cy = 127.5;
  config.counts = {count};
  return config;
}

/// One hinge, front up, in the middle of the bin.
class PickRule : public testing::Test {
 protected:
  PickRule() : cell_(smallCell(0), {loadPartKind(kParts + "hinge.yaml")}) {
    id_ = cell_.heap().put(0, at(-0.05, -0.03, 0.0022));
    cell_.heap().settle(3.0);
    cell_.update();
    T_base_part_ = cell_.heap().bodies().at(0).T_base_part;
  }
  /// The pick pose of the yaml, moved by millimetres and degrees in the tool's frame.
  Eigen::Isometry3d tool(double x_mm, double y_mm, double z_mm, double tilt_deg) const {
    return T_base_part_ * at(0.05, 0.025, 0.0) *
           Eigen::Isometry3d(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX())) *
           at(1e-3 * x_mm, 1e-3 * y_mm, 1e-3 * z_mm) *
           Eigen::Isometry3d(Eigen::AngleAxisd(tilt_deg * kPi / 180.0, Eigen::Vector3d::UnitY()));
  }
  SimulatedCell cell_;
  int id_ = 0;
  Eigen::Isometry3d T_base_part_;
};

TEST_F(PickRule, TakesAPartAtItsPickPose) {
  EXPECT_EQ(cell_.pick(tool(0.0, 0.0, 0.0, 0.0)), PickResult::kPicked);
  EXPECT_TRUE(cell_.heap().bodies().empty());
  EXPECT_EQ(cell_.pick(tool(0.0, 0.0, 0.0, 0.0)), PickResult::kNothing);
}

TEST_F(PickRule, TakesAPartJustWithinItsTolerances) {
  EXPECT_EQ(cell_.pick(tool(1.0, 0.0, -4.5, 4.5)), PickResult::kPicked);
}

TEST_F(PickRule, FailsBeyondEachTolerance) {
  EXPECT_EQ(cell_.pick(tool(1.7, 0.0, 0.0, 0.0)), PickResult::kLateral);
  EXPECT_EQ(cell_.heap().bodies().size(), 1u);
}

TEST_F(PickRule, FailsBeyondItsDepth) {
  // The cup touches nothing, so that nothing moves, however often it tries and wherever it hangs.
  for (const double x_mm : {0.0, 1.7, 0.0})
    EXPECT_EQ(cell_.pick(tool(x_mm, 0.0, -5.5, 0.0)), PickResult::kAbove);
  EXPECT_TRUE(cell_.heap().bodies().at(0).T_base_part.isApprox(T_base_part_, 0.0));
}

TEST_F(PickRule, FailsWhereItRunsIntoThePart) {
  // On a block: at the floor the tool would touch the bin.
  Eigen::Isometry3d T = T_base_part_;
  T.translation().z() += 0.02;
  cell_.heap().put(0, T);
  cell_.update();
  EXPECT_EQ(cell_.pick(tool(0.0, 0.0, -20.0 + 5.5, 0.0)), PickResult::kDepth);
}

TEST_F(PickRule, FailsBeyondItsTilt) {
  EXPECT_EQ(cell_.pick(tool(0.0, 0.0, 0.0, 5.5)), PickResult::kTilt);
}

TEST_F(PickRule, FailsWhereSomethingLiesUnderTheCup) {
  // Another hinge whose corner lies over the grasp point's edge.
  Eigen::Isometry3d T = T_base_part_;
  T.translation() += Eigen::Vector3d(0.05, 0.025 + 0.004, kThickness + 1e-4);
  cell_.heap().put(0, T);
  cell_.update();
  EXPECT_EQ(cell_.pick(tool(0.0, 0.0, 0.0, 0.0)), PickResult::kCovered);
}

TEST_F(PickRule, FailsWhereMuchLiesOnThePart) {
  // Another one over its far end, well beside the cup.
  Eigen::Isometry3d T = T_base_part_;
  T.translation() += Eigen::Vector3d(0.065, 0.0, kThickness + 1e-4);
  cell_.heap().put(0, T);
  cell_.heap().settle(3.0);
  cell_.update();
  T_base_part_ = cell_.heap().bodies().at(0).T_base_part;
  ASSERT_GT(cell_.heap().load(id_), 0.3);
  EXPECT_EQ(cell_.pick(tool(0.0, 0.0, 0.0, 0.0)), PickResult::kLoaded);
}

TEST_F(PickRule, StopsAtTheWall) {
  const Bin bin;
  const Eigen::Isometry3d T = at(0.5 * bin.length - 0.008, 0.0, 0.01) *
                              Eigen::Isometry3d(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  EXPECT_EQ(cell_.pick(T), PickResult::kWall);
}

TEST(SimulatedCell, TellsTheTruth) {
  SimulatedCell cell(smallCell(0), {loadPartKind(kParts + "hinge.yaml")});
  cell.heap().put(0, at(-0.1, -0.03, 0.0022));
  cell.heap().put(0, at(-0.05, -0.03, 0.0046));  // over half of it
  cell.heap().settle(3.0);
  cell.update();
  const auto truth = cell.truth(overhead());
  ASSERT_EQ(truth.size(), 2u);
  EXPECT_TRUE(truth[0].front_up);
  EXPECT_NEAR(truth[1].visible_fraction, 1.0, 0.01);
  EXPECT_NEAR(truth[0].visible_fraction, 0.5, 0.1);
}

TEST(SimulatedCell, IsTheSameForTheSameSeed) {
  const auto play = [](std::uint64_t seed) {
    SimulatedCell cell(smallCell(6), {loadPartKind(kParts + "bracket.yaml")});
    cell.refill(seed);
    cell.pick(cell.heap().bodies().at(5).T_base_part *
              Eigen::Isometry3d(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX())));
    return cell.takePicture(overhead(), 0.01);
  };
  const cv::Mat first = play(7);
  EXPECT_EQ(cv::norm(first, play(7), cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(first, play(8), cv::NORM_INF), 20.0);
}

TEST(LoadPartKind, RefusesAPartWithoutPickPoses) {
  EXPECT_THROW(loadPartKind(std::string(PACKAGE_DIR) + "/config/parts/bracket.yaml"),
               std::runtime_error);
}

}  // namespace
}  // namespace planar_bin_picking::cell
