// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/motion_limits.h"
#include "planar_bin_picking/base/se3.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace planar_bin_picking {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

MotionParams roomy() {
  MotionParams params;
  params.workspace_min_x = params.workspace_min_y = params.workspace_min_z = -1.0;
  params.workspace_max_x = params.workspace_max_y = params.workspace_max_z = 1.0;
  return params;
}

Eigen::Isometry3d at(double x, double y, double z) {
  return rigid(Eigen::Matrix3d::Identity(), {x, y, z});
}

Eigen::Isometry3d turned(double deg, const Eigen::Vector3d& axis) {
  return rigid(Eigen::AngleAxisd(deg * kDegree, axis.normalized()).toRotationMatrix(),
               Eigen::Vector3d::Zero());
}

MotionLimits limitsOf(const MotionParams& params) {
  return MotionLimits(params, Eigen::Isometry3d::Identity());
}

TEST(MotionLimits, BoxHoldsFlangeAndWhatIsMounted) {
  MotionLimits limits = limitsOf(roomy());
  EXPECT_TRUE(limits.allows(at(0.69, 0.0, 0.0)));
  EXPECT_FALSE(limits.allows(at(0.71, 0.0, 0.0)));  // mounted_radius_m is 0.3
  EXPECT_FALSE(limits.allows(at(0.0, -0.71, 0.0)));
  limits.setMounted({{{0.0, 0.0, 0.5}}, 0.1});
  EXPECT_TRUE(limits.allows(at(0.89, 0.0, 0.0)));
  EXPECT_FALSE(limits.allows(at(0.0, 0.0, 0.41)));
  EXPECT_TRUE(limits.allows(at(0.0, 0.0, 0.39)));
  EXPECT_TRUE(limits.allows(at(0.0, 0.0, -0.99)));
  EXPECT_FALSE(limits.allows(at(0.0, 0.0, -1.01)));
  EXPECT_NE(limits.whyNot(at(0.0, 0.0, 0.41)).find("mounted on the flange"), std::string::npos);
  const std::string reason = limits.whyNot(at(0.0, 0.0, 1.01));
  EXPECT_EQ(reason.find("the flange at ["), 0u) << reason;
  EXPECT_NE(reason.find("1.01] lies outside the workspace"), std::string::npos) << reason;
}

TEST(MotionLimits, NothingCrossesAPlane) {
  MotionParams params = roomy();
  params.planes = {0.0, 0.0, 1.0, -0.35, 0.6, 0.8, 0.0, -0.5};
  MotionLimits limits = limitsOf(params);
  EXPECT_TRUE(limits.allows(at(0.0, 0.0, -0.04)));
  EXPECT_FALSE(limits.allows(at(0.0, 0.0, -0.06)));
  EXPECT_NE(limits.whyNot(at(0.0, 0.0, -0.06)).find("beyond plane 1"), std::string::npos);
  EXPECT_TRUE(limits.allows(at(-0.33, 0.0, 0.0)));
  EXPECT_NE(limits.whyNot(at(-0.35, 0.0, 0.0)).find("beyond plane 2"), std::string::npos);
  limits.setMounted({{{0.0, 0.0, -0.2}}, 0.0});
  EXPECT_TRUE(limits.allows(at(0.0, 0.0, -0.14)));
  EXPECT_FALSE(limits.allows(at(0.0, 0.0, -0.16)));
}

TEST(MotionLimits, ConeAndRoll) {
  MotionParams params = roomy();
  params.cone_deg = 30.0;
  params.max_roll_deg = 60.0;
  const MotionLimits limits = limitsOf(params);
  EXPECT_TRUE(limits.allows(turned(29.9, {1, 1, 0})));
  EXPECT_FALSE(limits.allows(turned(30.1, {1, -1, 0})));
  EXPECT_NE(limits.whyNot(turned(31, {0, 1, 0})).find("cone_deg"), std::string::npos);
  EXPECT_TRUE(limits.allows(turned(59.9, {0, 0, -1})));
  EXPECT_FALSE(limits.allows(turned(60.1, {0, 0, 1})));
  EXPECT_NE(limits.whyNot(turned(-61, {0, 0, 1})).find("max_roll_deg"), std::string::npos);
  // The tilt is no roll, whatever way it goes.
  EXPECT_TRUE(limits.allows(turned(25, {1, 0.3, 0}) * turned(59.9, {0, 0, 1})));
  EXPECT_FALSE(limits.allows(turned(25, {1, 0.3, 0}) * turned(60.1, {0, 0, 1})));
}

TEST(MotionLimits, AtTheirLargestConeAndRollAreNone) {
  MotionParams params = roomy();
  params.cone_deg = params.max_roll_deg = 180.0;
  const MotionLimits limits = limitsOf(params);
  EXPECT_TRUE(limits.allowsTarget(turned(180, {1, 0, 0})));
  EXPECT_TRUE(limits.allowsTarget(turned(180, {0, 0, 1})));
  EXPECT_TRUE(limits.allowsTarget(turned(179, {1, 1, 0}) * turned(179.9, {0, 0, 1})));
}

TEST(MotionLimits, TargetsKeepADistance) {
  MotionParams params = roomy();
  params.cone_deg = 30.0;
  const MotionLimits limits = limitsOf(params);
  EXPECT_TRUE(limits.allowsTarget(at(0.69, 0.0, 0.0)));
  EXPECT_FALSE(limits.allowsTarget(at(0.695, 0.0, 0.0)));
  EXPECT_TRUE(limits.allows(at(0.695, 0.0, 0.0)));
  EXPECT_TRUE(limits.allowsTarget(turned(28.9, {1, 0, 0})));
  EXPECT_FALSE(limits.allowsTarget(turned(29.1, {1, 0, 0})));
  EXPECT_FALSE(limits.allowsTarget(turned(89.1, {0, 0, 1})));
}

TEST(MotionLimits, NotANumberIsNowhereAllowed) {
  const MotionLimits limits = limitsOf(roomy());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(limits.allows(at(nan, 0.0, 0.0)));
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear().setConstant(nan);
  EXPECT_FALSE(limits.allows(T));
  EXPECT_FALSE(limits.way(Eigen::Isometry3d::Identity(), T));
}

TEST(MotionLimits, WayHasPosesInBetween) {
  MotionParams params = roomy();
  params.mounted_radius_m = 0.0;
  const MotionLimits limits = limitsOf(params);
  const Eigen::Isometry3d here = at(0.0, 0.0, 0.0);
  EXPECT_TRUE(limits.way(here, here)->empty());
  EXPECT_EQ(limits.way(here, at(0.1, 0.0, 0.0))->size(), 1u);
  EXPECT_EQ(limits.way(here, at(0.1001, 0.0, 0.0))->size(), 2u);
  EXPECT_EQ(limits.way(here, turned(15.0, {1, 2, 0}))->size(), 1u);
  EXPECT_EQ(limits.way(here, turned(80.0, {0, 0, 1}))->size(), 6u);
  const auto way = limits.way(at(0.0, 0.0, 0.4), at(0.0, 0.0, -0.1));
  ASSERT_EQ(way->size(), 5u);
  EXPECT_NEAR((*way)[0].translation().z(), 0.3, 1e-9);
  EXPECT_NEAR((*way)[4].translation().z(), -0.1, 1e-9);
  EXPECT_FALSE(limits.way(here, at(1.1, 0.0, 0.0)));
  EXPECT_FALSE(limits.way(at(1.1, 0.0, 0.0), here));
}

/// The largest angle of the z axis on the way, and of the roll.
struct Largest {
  double cone = 0.0, step = 0.0, turn = 0.0;
};
Largest largestOn(const Eigen::Isometry3d& here, const std::vector<Eigen::Isometry3d>& way) {
  Largest out;
  Eigen::Isometry3d from = here;
  for (const Eigen::Isometry3d& to : way) {
    const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
    out.step = std::max(out.step, (to.translation() - from.translation()).norm());
    out.turn = std::max(out.turn, turn.angle() / kDegree);
    for (int i = 0; i <= 50; ++i) {
      const Eigen::Vector3d z =
          from.linear() *
          (Eigen::AngleAxisd(turn.angle() * i / 50.0, turn.axis()) * Eigen::Vector3d::UnitZ());
      out.cone = std::max(out.cone, std::atan2(std::hypot(z.x(), z.y()), z.z()) / kDegree);
    }
    from = to;
  }
  return out;
}

// The short turn between these two leads through 49 degrees.
TEST(MotionLimits, WayStaysInTheConeWhereAPlainTurnDoesNot) {
  const MotionLimits limits = limitsOf(roomy());
  const Eigen::Isometry3d one = turned(44.0, {1, 0, 0}) * turned(-60.0, {0, 0, 1});
  const Eigen::Isometry3d other = turned(44.0, {0.7, 0.7, 0}) * turned(60.0, {0, 0, 1});
  EXPECT_GT(largestOn(one, {other}).cone, 46.0);
  const auto way = limits.way(one, other);
  ASSERT_TRUE(way);
  const Largest largest = largestOn(one, *way);
  EXPECT_LE(largest.cone, 45.0 + 1e-6);
  EXPECT_LE(largest.turn, 15.0 + 1e-6);
  EXPECT_TRUE(isometryNear(way->back(), other, 1e-12, 1e-9));
}

// Ten thousand cells and pairs of poses: where there is a way, all of it is allowed.
TEST(MotionLimits, NoWayEverLeaves) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto share = [&] { return 0.5 + 0.5 * any(random); };
  int ways = 0, long_ways = 0;
  for (int round = 0; round < 10000; ++round) {
    MotionParams params = roomy();
    params.cone_deg = 10.0 + 130.0 * share();
    params.max_roll_deg = 10.0 + 170.0 * share();
    params.max_step_m = 0.02 + 0.5 * share();
    params.max_turn_deg = 2.0 + 80.0 * share();
    params.planes = {0.0, 0.0, 1.0, -0.4 - 0.5 * share()};
    const Eigen::Isometry3d start =
        exp((Vector6d() << 0, 0, 0, any(random), any(random), any(random)).finished());
    MotionLimits limits(params, start);
    const Eigen::Vector3d point(0.4 * any(random), 0.4 * any(random), 0.4 * any(random));
    limits.setMounted({{point}, 0.02});
    const auto draw = [&] {
      const Eigen::Isometry3d T =
          start * turned(params.cone_deg * share(), {any(random), any(random), 0.0}) *
          turned(params.max_roll_deg * any(random), {0, 0, 1});
      return rigid(T.linear(), {0.95 * any(random), 0.95 * any(random), 0.95 * any(random)});
    };
    const Eigen::Isometry3d here = draw(), there = draw();
    const auto way = limits.way(here, there);
    if (!way) continue;
    ++ways;
    long_ways += way->size() > 3 ? 1 : 0;
    Eigen::Isometry3d from = here;
    for (const Eigen::Isometry3d& to : *way) {
      const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
      ASSERT_LE(turn.angle(), params.max_turn_deg * kDegree + 1e-6);
      const Eigen::Vector3d step = to.translation() - from.translation();
      ASSERT_LE(step.norm(), params.max_step_m + 1e-6);
      for (int i = 0; i <= 30; ++i) {
        Eigen::Isometry3d T = from;
        T.translation() += i / 30.0 * step;
        T.rotate(Eigen::AngleAxisd(turn.angle() * i / 30.0, turn.axis()));
        const Eigen::Vector3d z = start.linear().transpose() * T.linear().col(2);
        ASSERT_LE(std::atan2(std::hypot(z.x(), z.y()), z.z()), params.cone_deg * kDegree + 1e-6);
        for (const Eigen::Vector3d& x : {T.translation().eval(), (T * point).eval()}) {
          ASSERT_LE(x.cwiseAbs().maxCoeff(), 1.0 + 1e-6);
          ASSERT_GE(x.z(), params.planes[3] - 1e-6);
        }
      }
      from = to;
    }
  }
  EXPECT_GT(ways, 1000);
  EXPECT_GT(long_ways, 500);
}

TEST(MotionLimits, InputIsChecked) {
  const auto refused = [](auto change, const std::vector<std::string>& words) {
    MotionParams params = roomy();
    change(&params);
    return refuses([&] { limitsOf(params); }, words);
  };
  EXPECT_TRUE(refuses([] { limitsOf(MotionParams()); }, {"the workspace is not set"}));
  EXPECT_TRUE(refused([](auto* p) { p->workspace_max_y = -1.0; }, {"workspace_max_y", "empty"}));
  EXPECT_TRUE(refused([](auto* p) { p->max_step_m = 0.0; }, {"max_step_m", "0.005"}));
  EXPECT_TRUE(refused([](auto* p) { p->planes = {0, 0, 1}; }, {"planes", "four"}));
  EXPECT_TRUE(refused([](auto* p) { p->planes = {0, 0, 2, 0}; }, {"plane 1", "must be 1"}));
  EXPECT_TRUE(refused([](auto* p) { p->planes = {0, 0, 1, 0}; }, {"must not start here", "plane"}));
  EXPECT_TRUE(refused([](auto* p) { p->workspace_min_z = 0.1; }, {"the flange", "workspace"}));
  EXPECT_TRUE(refused([](auto* p) { p->workspace_min_z = -0.2; }, {"mounted", "mounted_radius_m"}));
}

}  // namespace
}  // namespace planar_bin_picking
