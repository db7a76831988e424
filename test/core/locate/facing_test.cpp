// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Whatever path a pose took, its face and the direction of its z say the same: a robot whose tool
/// follows z would else come from below.

#include "part/visible_face.h"
#include "planar_bin_picking/locate/locator.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace planar_bin_picking {
namespace {

/// 34 x 22 mm, the same from both sides but for the print.
sim::Plate nameplate() {
  sim::Plate plate{rectangle(-17, -11, 17, 11), {}, {rectangle(-9, 1, 12, 7)}, 0.0};
  plate.holes = {circle(-13, 0, 2, true), circle(13, 0, 2, true)};
  return plate;
}

/// 36 mm square, the same after quarter turns, too.
sim::Plate squarePlate() {
  sim::Plate plate{rectangle(-18, -18, 18, 18), {}, {rectangle(-6, 1, 12, 8)}, 0.0};
  for (const double x : {-12.0, 12.0})
    for (const double y : {-12.0, 12.0}) plate.holes.push_back(circle(x, y, 2.4, true));
  return plate;
}

/// One plate on its back at the image's centre, where both solutions of a tilt look the same,
/// leaning the other way from five neighbours.
sim::Scene leaningAlone(const sim::Plate& plate, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double min, double max) {
    return min + (max - min) * static_cast<double>(random()) / 4294967295.0;
  };
  const double axis = uniform(0, 360), tilt = uniform(6, 10);
  sim::Scene scene;
  scene.seed = static_cast<int>(seed);
  scene.plates.push_back({plate, sim::poseOf({uniform(-6, 6), uniform(-6, 6), 600, uniform(0, 360),
                                              tilt, axis + 180, false})});
  for (int i = 0; i < 5; ++i) {
    const double around = (72.0 * i + uniform(-8, 8)) * kDegrees;
    scene.plates.push_back(
        {plate, sim::poseOf({105 * std::cos(around), 105 * std::sin(around), 600, uniform(0, 360),
                             tilt + uniform(-1, 1), axis, uniform(0, 1) < 0.5})});
  }
  return scene;
}

LocateResult locateIn(const sim::Scene& scene, const sim::Plate& plate) {
  LocateRequest request;
  request.parts = {makePart("plate", plate)};
  request.distance_min = 0.55;
  request.distance_max = 0.65;
  return Locator().locate(sim::takeImage(kPinhole, scene), makeCamera(kPinhole), request);
}

/// Every face and z agree, by the ray and by the optical axis.
void expectFacesAgree(const LocateResult& result, const PartModel& part) {
  std::vector<Detection> all = result.detections;
  for (const auto& w : result.withheld) all.push_back(w.detection);
  for (const Detection& d : all) {
    const Eigen::Vector3d centre = d.T_camera_part * centreOf(part, d.face).translation();
    const double along = d.T_camera_part.linear().col(2).dot(centre.normalized());
    EXPECT_EQ(along < 0.0, d.face == Face::kFront) << along << ", score " << d.score;
    EXPECT_EQ(faceOf(d.T_camera_part), d.face) << "score " << d.score;
  }
}

TEST(Facing, FaceAndZAgreeInRandomScenes) {
  constexpr unsigned kScenes = 15;
  for (const sim::Plate& plate : {nameplate(), squarePlate()}) {
    const auto part = makePart("plate", plate);
    unsigned right = 0;
    for (unsigned seed = 1; seed <= kScenes; ++seed) {
      const sim::Scene scene = leaningAlone(plate, seed);
      const auto result = locateIn(scene, plate);
      expectFacesAgree(result, *part);
      for (const auto& lying : scene.plates) {
        right += std::any_of(result.detections.begin(), result.detections.end(),
                             [&](const Detection& d) {
                               const Eigen::Vector3d off = d.T_camera_part.translation() -
                                                           lying.T_camera_part.translation();
                               return off.head<2>().norm() < 0.002 &&
                                      d.face == faceOf(lying.T_camera_part);
                             })
                     ? 1
                     : 0;
      }
    }
    EXPECT_EQ(right, 6 * kScenes);  // none is lost, either
  }
}

TEST(Facing, ShowsFaceIsAboutRayAxisAndPlace) {
  const auto part = makePart("plate", nameplate());
  const auto shows = [&](const sim::Lie& lie, Face face) {
    return showsFace(*part, sim::poseOf(lie), face);
  };
  EXPECT_TRUE(shows({0, 0, 600}, Face::kFront));
  EXPECT_FALSE(shows({0, 0, 600}, Face::kBack));
  EXPECT_TRUE(shows({0, 0, 600, 0, 0, 0, false}, Face::kBack));
  EXPECT_FALSE(shows({0, 0, 600, 0, 0, 0, false}, Face::kFront));
  EXPECT_FALSE(shows({0, 0, 600, 0, 91, 0}, Face::kFront));
  // 45 degrees to the right, tilted by 50 so that the ray meets it from behind or from the front.
  EXPECT_NE(shows({600, 0, 600, 0, 50, 90}, Face::kFront),
            shows({600, 0, 600, 0, -50, 90}, Face::kFront));
  // Behind the camera, and about it.
  EXPECT_FALSE(shows({0, 0, -600}, Face::kFront));
  EXPECT_FALSE(shows({0, 0, -600}, Face::kBack));
  // 20 mm of radius and half as much again for the grid, tilted by 60 degrees: 26 mm.
  EXPECT_FALSE(shows({0, 0, 25, 0, 60, 0}, Face::kFront));
  EXPECT_TRUE(shows({0, 0, 28, 0, 60, 0}, Face::kFront));
}

TEST(Facing, TheTiltIsSignedByTheFace) {
  for (const bool front : {true, false}) {
    const Face up = front ? Face::kFront : Face::kBack, down = front ? Face::kBack : Face::kFront;
    const Eigen::Isometry3d T = sim::poseOf({0, 0, 600, 20, 25, 70, front});
    EXPECT_NEAR(tiltOf(T, up), 25 * kDegrees, 1e-9);
    EXPECT_NEAR(tiltOf(T, down), 155 * kDegrees, 1e-9);
  }
}

}  // namespace
}  // namespace planar_bin_picking
