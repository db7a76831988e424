// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/field_alignment.h"

#include "support/stages.h"

#include <gtest/gtest.h>

#include <random>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{20, -10, 1200, 35, 0};
const RefineParams kParams;

/// A bracket on top of many thin strips that lie all about it.
sim::Scene heapedScene(int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  sim::Scene scene;
  scene.seed = seed;
  for (int i = 0; i < 200; ++i) {
    const sim::Lie lie{kLie.x_mm + uniform(-80, 80), kLie.y_mm + uniform(-80, 80), kLie.z_mm,
                       uniform(0, 360), 0};
    scene.plates.push_back(
        {{rectangle(-40, -1.5, 40, 1.5), {}, {}, 0.0}, sim::poseOf(lie), uniform(90, 230)});
  }
  scene.plates.push_back({bracketPlate(), sim::poseOf(kLie)});
  return scene;
}

/// From a start as the vote leaves it, within a cell and half a step of the yaw.
struct Aligned {
  double off_mm, tilt_deg;
};

Aligned alignedIn(const sim::Scene& scene) {
  const Shot shot = shoot(scene);
  const auto part = makePart("bracket", bracketPlate());
  const auto points = localPointsAt(*part, shapeIndices(*part, kParams.field_points));
  const Eigen::Isometry3d T_part_centre = centreOf(*part, Face::kFront);
  const Eigen::Isometry3d T_start =
      candidateNear(sim::poseOf(kLie), 3.0, 2.5).T_camera_part * T_part_centre;
  const Field& field = shot.edges.fieldOf(0);
  const double reach_px =
      kParams.field_reach_radii * field.focal * part->radius() / T_start.translation().z();
  const Eigen::Isometry3d T =
      alignInField(field, points, part->radius(), T_start, reach_px, kParams);
  const Eigen::Vector3d off = T.translation() - (sim::poseOf(kLie) * T_part_centre).translation();
  return {1e3 * off.head<2>().norm(),
          std::acos(std::min(1.0, std::abs(T.linear()(2, 2)))) / kDegrees};
}

TEST(FieldAlignment, AFlatPartStaysFlatAmongOtherEdges) {
  int held = 0;
  constexpr int kHeaps = 12;
  for (int seed = 1; seed <= kHeaps; ++seed) {
    const Aligned aligned = alignedIn(heapedScene(seed));
    held += aligned.off_mm < 3.0 && aligned.tilt_deg < 15.0 ? 1 : 0;
  }
  EXPECT_GE(held, kHeaps - 2);  // without what the vote knows of the tilt: 0
}

TEST(FieldAlignment, ATiltThatTheEdgesShowIsFollowed) {
  const auto part = makePart("bracket", bracketPlate());
  const sim::Lie lie{20, -10, 600, 35, 12, 40};
  const Shot shot = shoot(sceneOf(bracketPlate(), lie));
  const auto points = localPointsAt(*part, shapeIndices(*part, kParams.field_points));
  const Eigen::Isometry3d T_part_centre = centreOf(*part, Face::kFront);
  // The vote's cell is the untilted one.
  sim::Lie flat = lie;
  flat.tilt_deg = 0.0;
  const Eigen::Isometry3d T = alignInField(shot.edges.fieldOf(0), points, part->radius(),
                                           sim::poseOf(flat) * T_part_centre, 20.0, kParams);
  const Eigen::Vector3d normal = (sim::poseOf(lie) * T_part_centre).linear().col(2);
  EXPECT_LT(std::acos(T.linear().col(2).dot(normal)) / kDegrees, 5.0);
}

TEST(FieldAlignment, TheInlierScoreFallsWithTheDistance) {
  const auto part = makePart("bracket", bracketPlate());
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto points = localPointsAt(*part, shapeIndices(*part, kParams.field_points));
  const auto score = [&](double off_mm) {
    const Eigen::Isometry3d T =
        candidateNear(sim::poseOf(kLie), off_mm).T_camera_part * centreOf(*part, Face::kFront);
    return fieldInlierScore(shot.edges.fieldOf(0), points, part->radius(), T, 3.0);
  };
  EXPECT_GT(score(0.0), 0.7);
  EXPECT_LT(score(1.5), score(0.0) - 0.1);
  EXPECT_LT(score(200.0), 0.1);
}

}  // namespace
}  // namespace planar_bin_picking
