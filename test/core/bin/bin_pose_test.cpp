// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/bin/bin_pose.h"

#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kWall = 0.008;

/// Inner size 280 x 200 x 80 mm, its rim 0.7 m below the camera; the frame is at a corner of the
/// floor.
BinSearch search() {
  BinSearch search;
  search.told.max = {0.28, 0.20, 0.08};
  search.told.T_camera_bin = Eigen::Translation3d(-0.14, 0.10, 0.78) *
                             Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX());
  search.wall = kWall;
  return search;
}

/// The walls' tops, the floor with a part on it, and walls that are seen from above as dark
/// stripes.
sim::Scene binAt(const Eigen::Isometry3d& T_camera_bin) {
  sim::Plate rim{rectangle(-8, -8, 288, 208), {rectangle(0, 0, 280, 200)}, {}, 0.0};
  std::reverse(rim.holes[0].begin(), rim.holes[0].end());
  const sim::Plate floor{rectangle(0, 0, 280, 200), {}, {}, 0.0};
  sim::Scene scene;
  scene.plates.push_back({floor, T_camera_bin, 95.0});
  scene.plates.push_back(
      {bracketPlate(), T_camera_bin * Eigen::Translation3d(0.12, 0.09, 0.005), 170.0});
  scene.plates.push_back({rim, T_camera_bin * Eigen::Translation3d(0.0, 0.0, 0.08), 150.0});
  return scene;
}

/// About the middle of the rim.
Eigen::Isometry3d moved(const Eigen::Vector3d& by_mm, double turn_deg, double tilt_deg,
                        double axis_deg) {
  const Eigen::Translation3d middle(0.14, 0.10, 0.08);
  const Eigen::Vector3d axis(std::cos(axis_deg * kDegrees), std::sin(axis_deg * kDegrees), 0.0);
  return Eigen::Translation3d(1e-3 * by_mm) * middle *
         Eigen::AngleAxisd(tilt_deg * kDegrees, axis) *
         Eigen::AngleAxisd(turn_deg * kDegrees, Eigen::Vector3d::UnitZ()) * middle.inverse();
}

std::optional<FoundBin> look(const BinSearch& search, const sim::Scene& scene) {
  return findBin(sim::takeImage(kPinhole, scene), makeCamera(kPinhole), search, Locator());
}

TEST(BinPose, FindsABinThatWasMoved) {
  const BinSearch told = search();
  const Eigen::Isometry3d cases[] = {
      moved({0, 0, 0}, 0, 0, 0),         moved({40, 30, 0}, 9.5, 0, 0),
      moved({-35, -25, 20}, -9, 3, 30),  moved({20, -40, -30}, 5, 4.5, 120),
      moved({-50, 20, 10}, -4, 4.8, 80),
  };
  for (const Eigen::Isometry3d& T_told_found : cases) {
    const auto found = look(told, binAt(told.told.T_camera_bin * T_told_found));
    ASSERT_TRUE(found);
    const Eigen::Vector3d rim(0.14, 0.10, 0.08);
    const Eigen::Vector3d off = found->T_told_found * rim - T_told_found * rim;
    EXPECT_LT(off.norm(), 2e-3) << off.transpose();
    EXPECT_TRUE(isometryNear(found->T_told_found, T_told_found, 4e-3, 0.5 * kDegrees));
    EXPECT_TRUE(found->is_within) << found->moved << " " << found->turned_deg << " "
                                  << found->tilted_deg;
    EXPECT_NEAR(found->moved, (T_told_found * rim - rim).norm(), 2e-3);
  }
}

TEST(BinPose, NamesWhatIsTooFarOff) {
  const BinSearch told = search();
  const auto turned = look(told, binAt(told.told.T_camera_bin * moved({0, 0, 0}, 14, 0, 0)));
  ASSERT_TRUE(turned);
  EXPECT_FALSE(turned->is_within);
  EXPECT_NEAR(turned->turned_deg, 14.0, 0.5);
  BinSearch narrow = told;
  narrow.moved_max = 0.02;
  const auto off = look(narrow, binAt(told.told.T_camera_bin * moved({0, 25, 0}, 0, 0, 0)));
  ASSERT_TRUE(off);
  EXPECT_FALSE(off->is_within);
  EXPECT_NEAR(off->moved, 0.025, 2e-3);
}

TEST(BinPose, WhereThereIsNoneThereIsNone) {
  sim::Scene scene = binAt(search().told.T_camera_bin);
  scene.plates.pop_back();  // without its rim the floor is a smaller rectangle, far too low
  EXPECT_FALSE(look(search(), scene) && look(search(), scene)->is_within);
  scene.plates.clear();
  EXPECT_FALSE(look(search(), scene));
  BinSearch open = search();
  open.wall = 0.0;
  EXPECT_TRUE(refuses([&] { rimOf(open); }, {"walls"}));
  BinSearch flat = search();
  flat.told.max.x() = flat.told.min.x();
  EXPECT_TRUE(refuses([&] { rimOf(flat); }, {"no size"}));
}

}  // namespace
}  // namespace planar_bin_picking
