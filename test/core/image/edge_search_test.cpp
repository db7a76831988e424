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
  const EdgeSearch alone(shot.edges, kPaired);
  Found out;
  const double share = 1.0 / static_cast<double>(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    PosedPoint at;
    EXPECT_TRUE(posePoint(shot.camera, points[i], solid.radius, T, &at));
    out.alone += alone.at(at).found ? share : 0.0;
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

}  // namespace
}  // namespace planar_bin_picking
