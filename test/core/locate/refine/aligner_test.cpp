// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/aligner.h"

#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <array>

namespace planar_bin_picking {
namespace {

sim::Scene sceneAt(const sim::Plate& plate, const Eigen::Isometry3d& T_camera_part) {
  sim::Scene scene;
  scene.plates.push_back({plate, T_camera_part});
  return scene;
}

/// One part in a scene.
struct Viewed {
  Viewed(const sim::Plate& plate, const sim::Scene& scene, const RefineParams& wanted = {})
      : params(wanted),
        shot(shoot(scene)),
        parts{makePart("plate", plate)},
        aligner(shot.edges, shot.camera, params, parts) {}
  Viewed(const Viewed&) = delete;
  Viewed& operator=(const Viewed&) = delete;

  RefineParams params;
  Shot shot;
  Parts parts;
  Aligner aligner;
};

PoseHypothesis hypothesisAt(const Eigen::Isometry3d& T_camera_part, double inlier_score = 0.0) {
  PoseHypothesis pose;
  pose.face = faceOf(T_camera_part);
  pose.T_camera_part = T_camera_part;
  pose.inlier_score = inlier_score;
  return pose;
}

/// With so few points nothing is aligned, and the best of the starts is left as it is: each of them
/// is the true pose once. Half a step of the vote nearer and farther, and 0.12 rad about x and y.
TEST(Aligner, TheSearchStartsAtEachSide) {
  RefineParams params;
  params.wide_points = kFewEdges - 1;
  const Eigen::Isometry3d truth = sim::poseOf({10, -5, 500, 20, 25, 65});
  const Viewed viewed(bracketPlate(), sceneAt(bracketPlate(), truth), params);
  const Eigen::Isometry3d T_part_centre = centreOf(*viewed.parts[0], Face::kFront);
  const std::array<std::array<double, 3>, 6> starts = {
      {{0.03, 0, 0}, {-0.03, 0, 0}, {0, 0.12, 0}, {0, -0.12, 0}, {0, 0, 0.12}, {0, 0, -0.12}}};
  for (const auto& [farther, about_x, about_y] : starts) {
    Eigen::Isometry3d T = truth * T_part_centre;
    T.translation() /= 1.0 + farther;
    T.rotate(Eigen::AngleAxisd(-about_x, Eigen::Vector3d::UnitX()));
    T.rotate(Eigen::AngleAxisd(-about_y, Eigen::Vector3d::UnitY()));
    PoseHypothesis pose = hypothesisAt(T * T_part_centre.inverse());
    viewed.aligner.searchAround(&pose);
    EXPECT_TRUE(isometryNear(pose.T_camera_part, truth, 1e-9, 1e-6))
        << farther << " " << about_x << " " << about_y;
    EXPECT_FALSE(pose.searched);
    EXPECT_GT(pose.inlier_score, 0.5);
  }
}

TEST(Aligner, ASearchThatFindsNothingBetterIsTheLast) {
  RefineParams params;
  params.search_below = 1.0;
  const Eigen::Isometry3d truth = sim::poseOf({10, -5, 500, 20, 25, 65});
  const Viewed viewed(bracketPlate(), sceneAt(bracketPlate(), truth), params);
  const Eigen::Isometry3d off = candidateNear(truth, 1.0).T_camera_part;
  PoseHypothesis pose = hypothesisAt(off, 0.9999);  // told to be better than any can be
  viewed.aligner.searchAround(&pose);
  EXPECT_TRUE(pose.searched);
  EXPECT_TRUE(pose.T_camera_part.isApprox(off, 0.0));
  pose.inlier_score = 0.0;  // would be found now
  viewed.aligner.searchAround(&pose);
  EXPECT_TRUE(pose.T_camera_part.isApprox(off, 0.0));
  pose.searched = false;
  viewed.aligner.searchAround(&pose);
  EXPECT_TRUE(isometryNear(pose.T_camera_part, truth, 1e-3, 1.5 * kDegrees));
  // One that is good enough needs none.
  params.search_below = 0.9;
  const Viewed sure(bracketPlate(), sceneAt(bracketPlate(), truth), params);
  pose = hypothesisAt(off, 0.95);
  sure.aligner.searchAround(&pose);
  EXPECT_FALSE(pose.searched);
  EXPECT_TRUE(pose.T_camera_part.isApprox(off, 0.0));
}

/// Square plates of `half` millimetres about the optical axis, 600 mm off: 2.83 pixels to one.
constexpr double kPixelsPerMm = 1.7 / 0.6;

sim::Plate square(double half) { return {rectangle(-half, -half, half, half), {}, {}, 0.0}; }

/// Whether a square is aligned to the edges of one that is so many pixels larger on all sides.
bool reaches(double half, double off_px) {
  const Eigen::Isometry3d T = sim::poseOf({0, 0, 600});
  const Viewed viewed(square(half), sceneAt(square(half + off_px / kPixelsPerMm), T));
  PoseHypothesis pose = hypothesisAt(T);
  viewed.aligner.alignWide(&pose);
  return pose.image.status == AlignmentStatus::kAligned;
}

/// 0.03 of the radius (of the corners), but 6 pixels at least and 14 at most.
TEST(Aligner, TheWideReachFollowsThePartsSizeInTheImage) {
  EXPECT_TRUE(reaches(20.0, 4.5));
  EXPECT_FALSE(reaches(20.0, 8.0));  // of 80 pixels: 6
  EXPECT_FALSE(reaches(40.0, 8.0));  // of 160 pixels: 6
  EXPECT_TRUE(reaches(80.0, 8.0));   // of 320 pixels: 10
  EXPECT_FALSE(reaches(80.0, 12.5));
}

/// Share of the points that count for a square of which a piece of 20 mm of 240 is seen so many
/// pixels off, as a neighbour's edge.
double shareUsed(double off_px, int points, void (Aligner::*align)(PoseHypothesis*) const) {
  const Eigen::Isometry3d T = sim::poseOf({0, 0, 600});
  const double x = 30.0 + off_px / kPixelsPerMm;
  sim::Plate drawn = square(30.0);
  drawn.outer = {{-30, -30}, {30, -30}, {30, -10}, {x, -10},
                 {x, 10},    {30, 10},  {30, 30},  {-30, 30}};
  const Viewed viewed(square(30.0), sceneAt(drawn, T));
  PoseHypothesis pose = hypothesisAt(T);
  (viewed.aligner.*align)(&pose);
  EXPECT_TRUE(isometryNear(pose.T_camera_part, T, 2e-3, 3.0 * kDegrees)) << off_px;
  return static_cast<double>(pose.image.used) / points;
}

/// At the end of its reach an edge is taken for another's: from 4 pixels and from 2 on.
TEST(Aligner, WhatIsNearTheEndOfTheReachDoesNotCount) {
  const RefineParams params;
  const int wide = params.wide_points, fine = params.image_points;
  EXPECT_LT(shareUsed(4.6, wide, &Aligner::alignWide), 0.95);
  EXPECT_GT(shareUsed(1.0, wide, &Aligner::alignWide), 0.97);
  EXPECT_LT(shareUsed(3.0, fine, &Aligner::alignNarrow), 0.95);
  EXPECT_GT(shareUsed(0.5, fine, &Aligner::alignNarrow), 0.97);
}

/// The field attracts from 0.13 radii off; candidates are not nearer.
TEST(Aligner, TheFieldReachesAsFarAsACandidateIsOff) {
  const Eigen::Isometry3d truth = sim::poseOf({10, -5, 600, 20});
  const Viewed viewed(bracketPlate(), sceneAt(bracketPlate(), truth));
  for (const double off_mm : {-4.0, 4.0}) {
    const PoseHypothesis pose = viewed.aligner.alignToField(candidateNear(truth, off_mm));
    EXPECT_LT((pose.T_camera_part.translation() - truth.translation()).head<2>().norm(), 1.5e-3);
    EXPECT_GT(pose.inlier_score, viewed.params.field_inliers_min);
  }
}

/// ... and no farther: other edges are a neighbour's.
TEST(Aligner, TheFieldDoesNotReachANeighboursEdges) {
  const Eigen::Isometry3d T = sim::poseOf({0, 0, 600});
  const Viewed viewed(square(20.0), sceneAt(square(28.0), T));  // 0.28 radii all around
  const PoseHypothesis pose = viewed.aligner.alignToField(candidateNear(T));
  EXPECT_TRUE(isometryNear(pose.T_camera_part, T, 1e-6, 1e-4));
  EXPECT_LT(pose.inlier_score, viewed.params.field_inliers_min);
}

}  // namespace
}  // namespace planar_bin_picking
