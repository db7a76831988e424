// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/robot/orientation.h"

#include "support/matchers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace planar_bin_picking {
namespace {

constexpr PoseConvention kAll[] = {PoseConvention::kKuka,    PoseConvention::kFanuc,
                                   PoseConvention::kUr,      PoseConvention::kAbb,
                                   PoseConvention::kStaubli, PoseConvention::kPlain};

Eigen::Isometry3d turned(double degrees, const Eigen::Vector3d& axis) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(degrees * M_PI / 180.0, axis.normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(0.5, -0.25, 0.125);
  return T;
}

void expectNear(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-9) << i;
}

TEST(Orientation, GoesRoundInEachConvention) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d axis(normal(random), normal(random), normal(random));
    const Eigen::Isometry3d T = turned(360.0 * normal(random), axis);
    for (const PoseConvention convention : kAll)
      EXPECT_TRUE(isometryNear(fromNumbers(toNumbers(T, convention), convention), T, 1e-12, 1e-7));
  }
}

// Where two axes fall together, and where an angle is half a turn.
TEST(Orientation, GoesRoundAtItsCorners) {
  for (const double x : {0.0, 90.0, 180.0, -90.0}) {
    for (const double y : {0.0, 90.0, -90.0, 180.0}) {
      for (const double z : {0.0, 37.0, 90.0, 180.0}) {
        const Eigen::Isometry3d T = fromNumbers({1, 2, 3, x, y, z}, PoseConvention::kPlain);
        for (const PoseConvention convention : kAll)
          EXPECT_TRUE(
              isometryNear(fromNumbers(toNumbers(T, convention), convention), T, 1e-12, 1e-7));
      }
    }
  }
}

// Each against its own manual's definition, not against itself.
TEST(Orientation, KukaTurnsAboutZThenTheNewYThenTheNewX) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(30 * M_PI / 180, Eigen::Vector3d::UnitZ()));
  T.rotate(Eigen::AngleAxisd(20 * M_PI / 180, Eigen::Vector3d::UnitY()));
  T.rotate(Eigen::AngleAxisd(10 * M_PI / 180, Eigen::Vector3d::UnitX()));
  expectNear(toNumbers(T, PoseConvention::kKuka), {0, 0, 0, 30, 20, 10});
}

TEST(Orientation, FanucTurnsAboutFixedXThenYThenZ) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.prerotate(Eigen::AngleAxisd(10 * M_PI / 180, Eigen::Vector3d::UnitX()));
  T.prerotate(Eigen::AngleAxisd(20 * M_PI / 180, Eigen::Vector3d::UnitY()));
  T.prerotate(Eigen::AngleAxisd(30 * M_PI / 180, Eigen::Vector3d::UnitZ()));
  expectNear(toNumbers(T, PoseConvention::kFanuc), {0, 0, 0, 10, 20, 30});
  expectNear(toNumbers(T, PoseConvention::kPlain), {0, 0, 0, 10, 20, 30});
}

TEST(Orientation, StaubliTurnsAboutXThenTheNewYThenTheNewZ) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(10 * M_PI / 180, Eigen::Vector3d::UnitX()));
  T.rotate(Eigen::AngleAxisd(20 * M_PI / 180, Eigen::Vector3d::UnitY()));
  T.rotate(Eigen::AngleAxisd(30 * M_PI / 180, Eigen::Vector3d::UnitZ()));
  expectNear(toNumbers(T, PoseConvention::kStaubli), {0, 0, 0, 10, 20, 30});
}

TEST(Orientation, UrHasMetresAndARotationVector) {
  expectNear(toNumbers(turned(90.0, Eigen::Vector3d::UnitY()), PoseConvention::kUr),
             {0.5, -0.25, 0.125, 0.0, M_PI / 2.0, 0.0});
}

TEST(Orientation, AbbHasTheScalarFirst) {
  const double half = std::sqrt(0.5);
  expectNear(toNumbers(turned(90.0, Eigen::Vector3d::UnitZ()), PoseConvention::kAbb),
             {500.0, -250.0, 125.0, half, 0.0, 0.0, half});
  expectNear(toNumbers(turned(270.0, Eigen::Vector3d::UnitZ()), PoseConvention::kAbb),
             {500.0, -250.0, 125.0, half, 0.0, 0.0, -half});
}

TEST(Orientation, RefusesWhatIsNoPose) {
  const auto from = [](const std::vector<double>& numbers, PoseConvention convention) {
    return [=] { fromNumbers(numbers, convention); };
  };
  EXPECT_TRUE(refuses(from({1, 2, 3}, PoseConvention::kKuka), {"6 numbers", "3"}));
  EXPECT_TRUE(refuses(from({1, 2, 3, 4, 5, 6}, PoseConvention::kAbb), {"7 numbers"}));
  EXPECT_TRUE(refuses(from({1, 2, 3, NAN, 5, 6}, PoseConvention::kKuka), {"finite"}));
  EXPECT_TRUE(refuses(from({500, 2, 3, 0, 0, 0}, PoseConvention::kUr), {"metres"}));
  EXPECT_TRUE(refuses(from({1, 2, 3, 1, 1, 0, 0}, PoseConvention::kAbb), {"length 1.41"}));
  EXPECT_FALSE(poseConvention("epson").has_value());
  EXPECT_EQ(poseConvention("staubli"), PoseConvention::kStaubli);
}

}  // namespace
}  // namespace planar_bin_picking
