// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/refine.h"

#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

std::vector<RefinedPose> refined(const Shot& shot, const Parts& parts,
                                 const std::vector<Candidate>& candidates,
                                 const RefineParams& params = {}, int threads = 1) {
  return refineCandidates(shot.edges, shot.camera, parts, candidates, std::nullopt, 0.5, params,
                          threads);
}

/// A tenth of a pixel is 0.04 mm here; depth and tilt follow from the outline's size, 80 mm.
constexpr double kMetres = 0.5e-3, kRadians = 0.5 * kDegrees;

TEST(Refine, AlignsThePartFromARoughStart) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  for (const bool front : {true, false}) {
    for (const double tilt : {4.0, 25.0}) {
      const sim::Lie lie{30, -20, 610, 40, tilt, 70, front};
      const Eigen::Isometry3d truth = sim::poseOf(lie);
      const auto poses = refined(shoot(sceneOf(bracketPlate(), lie)), parts,
                                 {candidateNear(truth, 2.0, 2.5, 5.0)});
      ASSERT_EQ(poses.size(), 1u) << front << " " << tilt;
      EXPECT_TRUE(isometryNear(poses[0].T_camera_part, truth, kMetres, kRadians));
      EXPECT_EQ(poses[0].face, faceOf(truth));
      EXPECT_LT(poses[0].residual_px, 0.3);
    }
  }
}

TEST(Refine, KeepsWhatTheRankMayKeep) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const sim::Lie lie{10, -5, 600, 20};
  const Eigen::Isometry3d truth = sim::poseOf(lie);
  const Shot shot = shoot(sceneOf(bracketPlate(), lie));
  RefineParams params;  // that drop nothing by its own score
  params.field_inliers_min = params.image_inliers_min = params.search_inliers_min = 0.0;
  const auto countAt = [&](double overlap_max) {
    const std::vector<Candidate> candidates = {candidateNear(truth), candidateNear(truth, 4.0, 28)};
    return refineCandidates(shot.edges, shot.camera, parts, candidates, std::nullopt, overlap_max,
                            params, 1)
        .size();
  };
  EXPECT_EQ(countAt(0.5), 1u);
  EXPECT_EQ(countAt(1.0), 2u);
}

TEST(Refine, TheCovarianceHoldsTheError) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  double sum = 0.0;
  int count = 0;
  for (int seed = 1; seed <= 12; ++seed) {
    sim::Scene scene = sceneOf(bracketPlate(), {10.0 * seed - 60, 20, 600, 30.0 * seed, 10});
    scene.seed = seed;
    const Eigen::Isometry3d truth = scene.plates[0].T_camera_part;
    const auto poses = refined(shoot(scene), parts, {candidateNear(truth)});
    ASSERT_EQ(poses.size(), 1u);
    Eigen::Isometry3d T_part_centre = Eigen::Isometry3d::Identity();
    T_part_centre.translation() << parts[0]->center(), 0.0;
    const Eigen::Isometry3d off =
        (poses[0].T_camera_part * T_part_centre).inverse() * truth * T_part_centre;
    const Eigen::AngleAxisd turn(off.linear());
    Vector6d xi;
    xi << off.translation(), turn.angle() * turn.axis();
    EXPECT_GT(poses[0].covariance.ldlt().vectorD().minCoeff(), 0.0);
    sum += xi.dot(poses[0].covariance.ldlt().solve(xi));
    ++count;
  }
  // Six per pose where it is honest in a real scene; a drawn one has none of the shifts that light
  // and bevel cause along whole sides, which the covariance allows for.
  EXPECT_LT(sum / count, 6.0);
  EXPECT_GT(sum / count, 0.02);
}

/// A disk with three holes, cut `offset_mm` into the material all around, as a bevel shows it.
sim::Plate bevelledDisk(double offset_mm) {
  sim::Plate plate;
  plate.outer = circle(0, 0, 24 - offset_mm);
  plate.holes = {circle(12, 0, 5 + offset_mm, true), circle(-9, 10, 3 + offset_mm, true),
                 circle(-5, -13, 4 + offset_mm, true)};
  return plate;
}

TEST(Refine, EachCopyKeepsTheOffsetOfItsOwnEdges) {
  const Parts parts = {makePart("disk", bevelledDisk(0.0))};
  sim::Scene scene;
  std::vector<double> offsets_mm;
  std::vector<Candidate> candidates;
  for (int i = 0; i < 6; ++i) {
    offsets_mm.push_back(i % 2 == 0 ? 0.0 : 0.3);
    scene.plates.push_back(sceneOf(bevelledDisk(offsets_mm.back()),
                                   {60.0 * (i % 3) - 60, 60.0 * (i / 3) - 30, 600, 50.0 * i})
                               .plates[0]);
    candidates.push_back(candidateNear(scene.plates.back().T_camera_part));
  }
  const auto poses = refined(shoot(scene), parts, candidates);
  ASSERT_EQ(poses.size(), 6u);
  for (const auto& pose : poses) {
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d truth = scene.plates[i].T_camera_part.translation();
      const Eigen::Vector3d found = pose.T_camera_part.translation();
      if ((found - truth).head<2>().norm() > 0.01) continue;
      // Taken for distance, 0.3 mm of 24 would be 7.5 mm.
      EXPECT_NEAR(found.z(), truth.z(), 2e-3) << i;
      EXPECT_NEAR(1e3 * pose.edge_offset, offsets_mm[i], 0.12) << i;
    }
  }
}

TEST(Refine, OfManyStartsOnePoseIsLeft) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const sim::Lie lie{30, -20, 610, 40, 8};
  const Eigen::Isometry3d truth = sim::poseOf(lie);
  std::vector<Candidate> starts;
  for (const double off : {-2.0, 0.0, 2.0}) {
    for (const double turn : {-2.0, 2.0}) starts.push_back(candidateNear(truth, off, turn));
  }
  EXPECT_EQ(refined(shoot(sceneOf(bracketPlate(), lie)), parts, starts).size(), 1u);
}

TEST(Refine, AWrongStartIsDropped) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const sim::Lie lie{30, -20, 610, 40, 8};
  const Shot shot = shoot(sceneOf(bracketPlate(), lie));
  EXPECT_TRUE(refined(shot, parts, {candidateNear(sim::poseOf(lie), -120.0)}).empty());
  EXPECT_TRUE(refined(shot, parts, {}).empty());
}

TEST(Refine, AKeywayTellsTheTooth) {
  const sim::Plate wheel = wheelPlate(15, true);
  const Parts parts = {makePart("wheel", wheel)};
  const sim::Lie lie{20, 10, 600, 12, 5};
  const Eigen::Isometry3d truth = sim::poseOf(lie);
  const Shot shot = shoot(sceneOf(wheel, lie));
  for (const double teeth : {1.0, 4.0, 7.0}) {
    const auto poses = refined(shot, parts, {candidateNear(truth, 0.0, 24.0 * teeth)});
    ASSERT_EQ(poses.size(), 1u) << teeth;
    const double turn =
        Eigen::AngleAxisd(truth.linear().transpose() * poses[0].T_camera_part.linear()).angle();
    // The keyway is seen from behind just as well: there the pose is another one.
    if (poses[0].face == faceOf(truth)) {
      EXPECT_LT(turn, 1.0 * kDegrees) << teeth;
    }
  }
}

TEST(Refine, AFineGearIsNotTurnedByHalfATooth) {
  constexpr int kTeeth = 44;
  constexpr double kPitch = 360.0 / kTeeth;
  const Parts parts = {makePart("gear", wheelPlate(kTeeth, false))};
  for (int k = 0; k < 6; ++k) {
    const sim::Lie lie{20, -10, 600, 1.3 * k, 4.0 * k};
    const sim::Scene scene = sceneOf(wheelPlate(kTeeth, false), lie);
    const auto poses = refined(shoot(scene), parts, {candidateNear(sim::poseOf(lie), 0.5, 1.0)});
    ASSERT_EQ(poses.size(), 1u) << k;
    const Eigen::Matrix3d off =
        sim::poseOf(lie).linear().transpose() * poses[0].T_camera_part.linear();
    const double turn = std::atan2(off(1, 0), off(0, 0)) / kDegrees;
    EXPECT_NEAR(std::remainder(turn, kPitch), 0.0, 0.5) << k;
  }
}

TEST(Refine, APrintTellsTheFaceAndTheQuarter) {
  const Parts parts = {makePart("printed", printedPlate())};
  for (const bool front : {true, false}) {
    const sim::Lie lie{20, 10, 600, 12, 5, 0, front};
    const Eigen::Isometry3d truth = sim::poseOf(lie);
    const auto poses =
        refined(shoot(sceneOf(printedPlate(), lie)), parts, {candidateNear(truth, 0.5, 90.0)});
    ASSERT_EQ(poses.size(), 1u);
    EXPECT_EQ(poses[0].face, front ? Face::kFront : Face::kBack);
    if (front) {
      EXPECT_TRUE(isometryNear(poses[0].T_camera_part, truth, kMetres, kRadians));
    }
  }
}

TEST(Refine, ThreadsDoNotMatter) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  sim::Scene scene = sceneOf(bracketPlate(), {-80, -60, 600, 10});
  scene.plates.push_back({bracketPlate(), sim::poseOf({80, 60, 600, 200, 15, 30, false})});
  const Shot shot = shoot(scene);
  std::vector<Candidate> starts;
  for (const auto& plate : scene.plates) starts.push_back(candidateNear(plate.T_camera_part, 1, 2));
  const auto one = refined(shot, parts, starts), two = refined(shot, parts, starts, {}, 2);
  ASSERT_EQ(one.size(), 2u);
  ASSERT_EQ(two.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(one[i].T_camera_part.matrix(), two[i].T_camera_part.matrix());
    EXPECT_EQ(one[i].covariance, two[i].covariance);
  }
}

}  // namespace
}  // namespace planar_bin_picking
