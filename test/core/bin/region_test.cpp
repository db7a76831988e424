// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/bin/region.h"

#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

namespace planar_bin_picking {
namespace {

/// Looks straight down from 0.8 m; x as the region's, y against it.
const Eigen::Isometry3d kRegionCamera =
    Eigen::Translation3d(0.0, 0.0, 0.8) * Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX());
constexpr Distances kDistances{0.7, 0.8};

Camera testCamera() {
  Camera::Model model;
  model.width = 1000, model.height = 800;
  model.fx = model.fy = 1000.0, model.cx = 500.0, model.cy = 400.0;
  return Camera(model);
}

TEST(Region, TwoCornersAreABox) {
  const RegionOutline box = regionOutline(std::vector<double>{0.3, 0.2, 0.1, 0.4});
  ASSERT_EQ(box.size(), 4u);
  EXPECT_TRUE(isWithin(box, {0.2, 0.3}));
  EXPECT_FALSE(isWithin(box, {0.2, 0.19}));
  EXPECT_FALSE(isWithin(box, {0.31, 0.3}));
}

TEST(Region, PolygonsMayBeConcave) {
  const RegionOutline corner =
      regionOutline(std::vector<double>{0, 0, 4, 0, 4, 1, 1, 1, 1, 4, 0, 4});
  EXPECT_TRUE(isWithin(corner, {0.5, 3.0}));
  EXPECT_TRUE(isWithin(corner, {3.0, 0.5}));
  EXPECT_FALSE(isWithin(corner, {2.0, 2.0}));
  EXPECT_TRUE(isWithin({}, {1e6, -1e6}));
}

TEST(Region, RefusesWhatIsNoOutline) {
  const auto of = [](const std::vector<double>& numbers) {
    return [numbers] { regionOutline(numbers); };
  };
  EXPECT_TRUE(regionOutline(std::vector<double>{}).empty());
  EXPECT_TRUE(refuses(of({1, 2, 3}), {"3 numbers"}));
  EXPECT_TRUE(refuses(of({1, 2}), {"2 numbers"}));
  EXPECT_TRUE(refuses(of({0, 0, 1, 1, 2, 2}), {"no area"}));
  EXPECT_TRUE(refuses(of({0, 0, 0, 1}), {"no area"}));
  EXPECT_TRUE(refuses(of({0, 0, 3, 0, 0, 1, 2, 2}), {"crosses itself"}));
  EXPECT_TRUE(refuses(of({0, 0, NAN, 1, 1, 1}), {"no number"}));
}

TEST(Region, SaysWhereAPointIsOutside) {
  Region region;
  const Camera camera = testCamera();
  const Eigen::Vector3d p(0.08, 0.0, 0.8);  // pixel 600, 400
  EXPECT_FALSE(outsideOf(region, camera, kRegionCamera, p));
  region.pixels = regionOutline(std::vector<double>{0, 0, 599, 800});
  EXPECT_NE(outsideOf(region, camera, kRegionCamera, p)->find("600, 400"), std::string::npos);
  region.pixels = regionOutline(std::vector<double>{0, 0, 601, 800});
  region.metres = regionOutline(std::vector<double>{-0.1, -0.1, 0.081, 0.1});
  EXPECT_FALSE(outsideOf(region, camera, kRegionCamera, p));
  region.metres = regionOutline(std::vector<double>{-0.1, -0.1, 0.079, 0.1});
  EXPECT_NE(outsideOf(region, camera, kRegionCamera, p)->find("0.080, 0.000 m"), std::string::npos);
}

TEST(Region, WindowHoldsAllPartsWithinIt) {
  Region region;
  const Camera camera = testCamera();
  EXPECT_FALSE(windowOf(region, camera, kRegionCamera, kDistances, 0.05));
  region.metres = regionOutline(std::vector<double>{0.1, 0.0, 0.2, 0.1});
  const auto window = windowOf(region, camera, kRegionCamera, kDistances, 0.05);
  ASSERT_TRUE(window);
  for (const double depth : {0.7, 0.75, 0.8}) {
    for (const Eigen::Vector2d& corner : region.metres) {
      for (const double side : {-0.05, 0.05}) {
        const Eigen::Vector2d p = camera.project({corner.x() + side, -corner.y() + side, depth});
        EXPECT_GE(p.x(), window->left);
        EXPECT_LE(p.x(), window->left + window->width);
        EXPECT_GE(p.y(), window->top);
        EXPECT_LE(p.y(), window->top + window->height);
      }
    }
  }
  EXPECT_LT(window->width, 400);
  EXPECT_LT(window->height, 400);
  region.pixels = regionOutline(std::vector<double>{700, 300, 720, 320});
  const auto less = windowOf(region, camera, kRegionCamera, kDistances, 0.05);
  ASSERT_TRUE(less);
  EXPECT_LT(less->width, 200);
  // Seen from the side, the prism may be anywhere; and what is not in the picture is not cut out of
  // it.
  const Eigen::Isometry3d level(Eigen::AngleAxisd(0.5 * EIGEN_PI, Eigen::Vector3d::UnitX()));
  region.pixels.clear();
  EXPECT_FALSE(windowOf(region, camera, level, kDistances, 0.05));
  region.metres = regionOutline(std::vector<double>{5.0, 5.0, 6.0, 6.0});
  EXPECT_FALSE(windowOf(region, camera, kRegionCamera, kDistances, 0.05));
}

TEST(Region, FileComesBackAsItWasSaved) {
  const TempDir folder;
  const std::string path = folder.path("region.yaml");
  EXPECT_FALSE(loadRegion(path));
  const RegionFile saved{"bin", regionOutline(std::vector<double>{0.1, -0.2, 0.3, 0.0, 0.2, 0.25})};
  saveRegion(path, saved);
  const auto loaded = loadRegion(path);
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->frame, "bin");
  EXPECT_EQ(loaded->metres, saved.metres);
  std::ofstream(path) << "frame: bin\nregion: [1, 2, 3]\n";
  EXPECT_TRUE(refuses([&] { loadRegion(path); }, {path, "3 numbers"}));
  std::ofstream(path) << "frame: bin\nregion: []\n";
  EXPECT_TRUE(refuses([&] { loadRegion(path); }, {path, "empty"}));
  std::ofstream(path) << "frame: bin\nregoin: [1, 2]\n";
  EXPECT_TRUE(refuses([&] { loadRegion(path); }, {path, "regoin"}));
}

}  // namespace
}  // namespace planar_bin_picking
