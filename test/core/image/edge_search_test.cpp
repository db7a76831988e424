// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/edge_search.h"

#include "support/stages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{20, -10, 600, 35, 6};
constexpr SearchProfile kPaired{3, true, 0.8};

/// Shares of the bracket's outline.
struct Found {
  double together = 0.0, alone = 0.0;
  double farthest_px = 0.0;  // of what was found together
};

/// What is found about the drawn place of a bracket in the scene.
Found search(const sim::Scene& scene) {
  const Shot shot = shoot(scene);
  const auto part = makePart("bracket", bracketPlate());
  const auto points = localPoints(*part, 320, [](const OutlinePoint&) { return true; });
  const Solid solid = solidOf(*part, Face::kFront);
  const Eigen::Isometry3d T = sim::poseOf(kLie) * centreOf(*part, Face::kFront);
  std::vector<EdgeHit> hits;
  findHits(shot.edges, shot.camera, points, solid, T, kPaired, &hits);
  std::vector<EdgeHit> alone;
  findEach(shot.edges, kPaired, posePoints(shot.camera, points, solid.radius, T), &alone);
  Found out;
  const double share = 1.0 / static_cast<double>(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.alone += alone[i].found ? share : 0.0;
    out.together += hits[i].found ? share : 0.0;
    if (hits[i].found)
      out.farthest_px = std::max(out.farthest_px, std::abs(static_cast<double>(hits[i].offset_px)));
  }
  return out;
}

/// A bracket hardly brighter than what it lies on.
sim::Scene faintScene(double contrast, double noise) {
  sim::Scene scene = sceneOf(bracketPlate(), kLie);
  scene.plates.back().grey = scene.background + contrast;
  scene.noise = noise;
  return scene;
}

TEST(EdgeSearch, NeighboursAgreeOnAFaintEdge) {
  const Found found = search(faintScene(16.0, 4.0));
  EXPECT_LT(found.alone, 0.6);
  EXPECT_GT(found.together, 0.9);
}

TEST(EdgeSearch, NeighboursDoNotAgreeOnNoise) {
  const Found found = search(faintScene(0.0, 4.0));
  EXPECT_LT(found.together, found.alone + 0.02);
  EXPECT_LT(found.together, 0.1);
}

TEST(EdgeSearch, CornersAndSmallHolesStayWhereTheyAre) {
  const Found found = search(faintScene(100.0, 1.0));
  EXPECT_NEAR(found.together, 1.0, 1e-9);
  EXPECT_LT(found.farthest_px, 1.0);
}

TEST(EdgeSearch, WhatLeavesTheImageIsNotFound) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto part = makePart("bracket", bracketPlate());
  const auto points = localPoints(*part, 100, [](const OutlinePoint&) { return true; });
  sim::Lie outside = kLie;
  outside.x_mm += 1000.0;
  std::vector<EdgeHit> hits(7);
  findHits(shot.edges, shot.camera, points, solidOf(*part, Face::kFront),
           sim::poseOf(outside) * centreOf(*part, Face::kFront), kPaired, &hits);
  ASSERT_EQ(hits.size(), points.size());
  for (const EdgeHit& hit : hits) EXPECT_FALSE(hit.found);
}

/// A picture whose grey level depends on x alone.
template <class Level>
EdgeMap pictureOf(Level&& level) {
  EdgeMap map;
  map.image.create(60, 100, CV_8U);
  for (int x = 0; x < map.image.cols; ++x)
    map.image.col(x).setTo(std::lround(level(static_cast<double>(x))));
  map.noise.fill(1.0f);
  return map;
}

/// 0 to 1 at `at`, as blurred as a lens leaves it.
double stepAt(double x, double at) { return 0.5 * std::erfc((at - x) / (0.7 * std::sqrt(2.0))); }

EdgeHit hitAt(const EdgeMap& map, double x, const SearchProfile& profile, double outward = 1.0) {
  PosedPoints points;
  points.x.fill(x);
  points.y.fill(30.0);
  points.nx.fill(outward);
  points.ny.fill(0.0);
  points.is_in_front.fill(true);
  std::vector<EdgeHit> hits;
  findEach(map, profile, {points}, &hits);
  return hits.front();
}

TEST(EdgeSearch, AStepIsFoundToATenthOfAPixel) {
  for (const SearchProfile& profile : {SearchProfile{4, true, 0.8}, SearchProfile{8, false, 1.2}}) {
    for (double off = -3.3; off < 3.4; off += 0.55) {
      const EdgeMap map = pictureOf([&](double x) { return 60 + 100 * stepAt(x, 50.0 + off); });
      for (const double outward : {-1.0, 1.0}) {
        const EdgeHit hit = hitAt(map, 50.0, profile, outward);
        ASSERT_TRUE(hit.found) << off;
        EXPECT_NEAR(hit.offset_px, outward * off, 0.1) << off;
        EXPECT_NEAR(hit.cosine, 1.0, 1e-3);
      }
    }
  }
}

TEST(EdgeSearch, ALineIsFoundAtItsMiddle) {
  for (double off = -2.0; off < 2.1; off += 0.4) {
    const EdgeMap map = pictureOf(
        [&](double x) { return 120 - 80 * (stepAt(x, 49.4 + off) - stepAt(x, 50.6 + off)); });
    const EdgeHit hit = hitAt(map, 50.0, kPaired);
    ASSERT_TRUE(hit.found) << off;
    EXPECT_NEAR(hit.offset_px, off, 0.4) << off;  // drawn to whole pixels by up to a third
  }
}

TEST(EdgeSearch, OfTwoClearEdgesTheNearerCounts) {
  for (const double side : {-1.0, 1.0}) {
    // The farther one is twice as strong; the order along the profile does not matter.
    const EdgeMap map = pictureOf([&](double x) {
      const double from_middle = side * (x - 50.0);
      return 40 + 50 * stepAt(from_middle, 1.0) + 100 * stepAt(from_middle, 6.0);
    });
    const EdgeHit hit = hitAt(map, 50.0, {8, false, 1.2});
    ASSERT_TRUE(hit.found);
    EXPECT_NEAR(hit.offset_px, side, 0.2);
  }
}

TEST(EdgeSearch, AnEdgeOutOfReachIsNone) {
  const EdgeMap map = pictureOf([](double x) { return 60 + 100 * stepAt(x, 57.0); });
  EXPECT_FALSE(hitAt(map, 50.0, kPaired).found);
  EXPECT_TRUE(hitAt(map, 50.0, {8, false, 1.2}).found);
}

TEST(EdgeSearch, AnEdgeCountsFromFourTimesTheNoiseOn) {
  const auto rising = [](double height) {
    return pictureOf([height](double x) { return 60 + height * stepAt(x, 50.0); });
  };
  EXPECT_FALSE(hitAt(rising(3.0), 50.0, kPaired).found);
  EXPECT_TRUE(hitAt(rising(8.0), 50.0, kPaired).found);
}

}  // namespace
}  // namespace planar_bin_picking
