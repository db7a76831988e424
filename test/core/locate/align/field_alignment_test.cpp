// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/align/field_alignment.h"

#include "support/stages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
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

/// A field of 200 x 200 pixels with the optical axis in its middle, alike in all directions: in
/// each column edges are so many pixels away.
Field fieldWith(const std::function<double(int)>& distance_px) {
  Field field;
  field.width = field.height = 200;
  field.focal = 200.0;
  field.cx = field.cy = 100.0;
  field.image_px = 1.0;
  for (int y = 0; y < field.height; ++y) {
    for (int x = 0; x < field.width; ++x) {
      const double units = std::min<double>(kFarDistance, kUnitsPerFieldPixel * distance_px(x));
      field.distance.insert(field.distance.end(), kDirections, static_cast<std::uint8_t>(units));
    }
  }
  return field;
}

/// A ring of one radius.
std::vector<LocalPoint> ring() {
  std::vector<LocalPoint> points;
  for (int i = 0; i < 24; ++i) {
    const double a = 15.0 * kDegrees * i;
    points.push_back({std::cos(a), std::sin(a), -std::sin(a), std::cos(a), i});
  }
  return points;
}

constexpr double kRingRadius = 0.02;  // metres: 4 field pixels at 1 m

/// The ring 1 m in front of the camera, its centre in that column of the field's middle row.
Eigen::Isometry3d ringAt(double column) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << (column - 100.0) / 200.0, 0.0, 1.0;
  T.linear() = Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return T;
}

double columnOf(const Eigen::Isometry3d& T) {
  return 100.0 + 200.0 * T.translation().x() / T.translation().z();
}

TEST(FieldAlignment, TheInlierScoreIsAShareOfTheReach) {
  const Field field = fieldWith([](int) { return 1.0; });
  const auto score = [&](const Eigen::Isometry3d& T, double reach_px) {
    return fieldInlierScore(field, ring(), kRingRadius, T, reach_px);
  };
  EXPECT_NEAR(score(ringAt(100.0), 4.0), 0.75, 1e-9);
  EXPECT_NEAR(score(ringAt(100.0), 2.0), 0.5, 1e-9);
  EXPECT_EQ(score(ringAt(100.0), 1.0), 0.0);
  // Out of view, and half of it: 11 of 24 points, and the two on the border itself.
  EXPECT_EQ(score(ringAt(-20.0), 4.0), 0.0);
  EXPECT_EQ(score(ringAt(220.0), 4.0), 0.0);
  EXPECT_NEAR(score(ringAt(-0.01), 4.0), 0.75 * 11.0 / 24.0, 1e-9);
  // What is behind the camera is not seen, though its lines of sight meet the field.
  Eigen::Isometry3d behind = ringAt(100.0);
  behind.translation().z() = -1.0;
  EXPECT_EQ(score(behind, 4.0), 0.0);
  EXPECT_EQ(fieldInlierScore(field, {}, kRingRadius, ringAt(100.0), 4.0), 0.0);
}

/// Downhill the edges come nearer, until they or the image end: what is out of reach or of view
/// counts as an outlier, so the ring stays.
TEST(FieldAlignment, NoStepLosesTheEdges) {
  RefineParams params;
  params.field_reach_end_px = 10.0;
  for (const int end : {0, 60}) {
    const Field field = fieldWith([end](int x) { return x < end ? 40.0 : 1.0 + (x - end) / 3.0; });
    const Eigen::Isometry3d T =
        alignInField(field, ring(), kRingRadius, ringAt(end + 9.0), 10.0, params);
    EXPECT_LT(columnOf(T), end + 8.0);
    EXPECT_GT(columnOf(T), end + 2.0);
  }
}

TEST(FieldAlignment, TheFirstEvaluationIsOfTheStart) {
  RefineParams params;
  const Field field = fieldWith([](int x) { return std::abs(x - 100.0); });
  const auto column = [&](int iterations) {
    params.field_iterations = iterations;
    return columnOf(alignInField(field, ring(), kRingRadius, ringAt(104.0), 12.0, params));
  };
  EXPECT_EQ(column(1), 104.0);
  EXPECT_LT(column(2), 103.95);
  EXPECT_LT(std::abs(column(14) - 100.0), std::abs(column(7) - 100.0) - 0.1);
}

/// Where no edge says anything: a tilt beyond the limit goes back to it, one within stays.
TEST(FieldAlignment, TheTiltLimitHoldsAllAround) {
  RefineParams params;
  params.tilt_limit_deg = 20.0;
  params.field_iterations = 40;
  const Field empty = fieldWith([](int) { return 40.0; });
  const auto aligned = [&](double tilt_deg, double about_deg, bool front) {
    const Eigen::Isometry3d start = sim::poseOf({0, 0, 1000, 30, tilt_deg, about_deg, front});
    return std::pair{start, alignInField(empty, ring(), kRingRadius, start, 2.0, params)};
  };
  for (const bool front : {true, false}) {
    for (const double about_deg : {0.0, 70.0, 160.0, 250.0}) {
      const Eigen::Isometry3d back = aligned(35.0, about_deg, front).second;
      const double tilt_deg = std::acos(std::abs(back.linear()(2, 2))) / kDegrees;
      EXPECT_NEAR(tilt_deg, 20.2, 0.3) << about_deg;
      const auto [start, stayed] = aligned(19.0, about_deg, front);
      EXPECT_TRUE(stayed.isApprox(start, 1e-9)) << about_deg;
    }
  }
}

}  // namespace
}  // namespace planar_bin_picking
