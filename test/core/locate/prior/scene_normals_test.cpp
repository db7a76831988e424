// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/prior/scene_normals.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = EIGEN_PI / 180.0;
constexpr std::size_t kOwn = 1000;  // number of the part that is asked about

double squareOf(double degrees) { return std::pow(degrees * kRadians, 2); }

Eigen::Vector3d tilted(double degrees) {
  return Eigen::AngleAxisd(degrees * kRadians, Eigen::Vector3d::UnitX()) *
         Eigen::Vector3d(0.0, 0.0, -1.0);
}

/// So many parts, each tilted by `degrees`, measured to a degree.
std::vector<SceneNormal> lying(double degrees, std::size_t count, double probability = 1.0) {
  std::vector<SceneNormal> out;
  for (std::size_t i = 0; i < count; ++i)
    out.push_back({tilted(degrees), squareOf(1.0), probability, i});
  return out;
}

double at(const std::vector<SceneNormal>& scene, double degrees, double sigma_deg = 1.0) {
  return logTiltDensity(scene, tilted(degrees), squareOf(sigma_deg), kOwn);
}

TEST(SceneNormals, ThoseOfTheOthersAreLikelier) {
  const auto scene = lying(0.0, 8);
  EXPECT_GT(at(scene, 0.0) - at(scene, 6.0), 5.0);
  // Some lie as no other: beyond a few degrees, farther is hardly less likely.
  EXPECT_LT(at(scene, 12.0) - at(scene, 16.0), 0.5);
  EXPECT_GT(at(scene, 12.0) - at(scene, 45.0), 3.0);
  // What is badly measured says less.
  EXPECT_LT(at(scene, 0.0, 8.0) - at(scene, 6.0, 8.0), 0.5);
}

/// The sum over the others of Gaussians as wide as both errors and a degree together, and one of 15
/// degrees about their mean.
TEST(SceneNormals, TheDensityIsThatOfTheKernels) {
  const auto scene = lying(0.0, 3);
  for (const double degrees : {0.0, 2.0, 5.0, 20.0}) {
    const double off2 = (tilted(degrees) - tilted(0.0)).squaredNorm();
    const double narrow = squareOf(2.0) + squareOf(1.0) + squareOf(1.0);
    const double wide = squareOf(2.0) + squareOf(15.0);
    EXPECT_NEAR(at(scene, degrees, 2.0),
                std::log(3.0 * std::exp(-0.5 * off2 / narrow) / narrow +
                         std::exp(-0.5 * off2 / wide) / wide),
                1e-9)
        << degrees;
  }
}

/// Half of a heap lies flat; the leaning half does not make that less telling.
TEST(SceneNormals, PartsThatLeanDoNotWidenThePeakOfThoseThatLieFlat) {
  auto scene = lying(0.0, 6);
  const double alone = at(scene, 0.0) - at(scene, 15.0);
  for (const double degrees : {-31.0, -22.0, -11.0, 9.0, 24.0, 33.0})
    scene.push_back({tilted(degrees), squareOf(1.0), 1.0, scene.size()});
  EXPECT_NEAR(at(scene, 0.0) - at(scene, 15.0), alone, 0.7);
}

TEST(SceneNormals, DoubtfulOnesCountByTheirProbability) {
  auto scene = lying(10.0, 4, 0.8);
  for (const SceneNormal& other : lying(-10.0, 4, 0.2)) scene.push_back(other);
  EXPECT_NEAR(at(scene, 10.0) - at(scene, -10.0), std::log(4.0), 0.1);
  for (SceneNormal& normal : scene) normal.probability = 0.0;
  EXPECT_EQ(at(scene, 10.0), 0.0);
}

TEST(SceneNormals, APartTellsNothingOfItself) {
  auto scene = lying(0.0, 5);
  const double without = at(scene, 10.0);
  scene.push_back({tilted(10.0), squareOf(0.1), 1.0, kOwn});
  EXPECT_EQ(at(scene, 10.0), without);
  EXPECT_EQ(logTiltDensity({scene.back()}, tilted(10.0), squareOf(1.0), kOwn), 0.0);
  EXPECT_EQ(at({}, 10.0), 0.0);
}

}  // namespace
}  // namespace planar_bin_picking
