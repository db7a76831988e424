// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/slides.h"

#include "locate/refine/aligner.h"
#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{10, -5, 500, 20};

Slides slidesOf(const PartModel& part) {
  return Slides(localPointsAt(part, shapeIndices(part, 320)));
}

/// T moved by millimetres along the part's x, and by a share farther.
Eigen::Isometry3d slid(Eigen::Isometry3d T, double along_mm, double farther) {
  T = T * Eigen::Translation3d(1e-3 * along_mm, 0.0, 0.0);
  T.translation() *= 1.0 + farther;
  return T;
}

TEST(Slides, OnlyOutlinesThatMostlyStayOnThemselvesHaveAny) {
  EXPECT_FALSE(slidesOf(*makePart("bar", slenderPlate())).empty());
  for (const auto& plate :
       {bracketPlate(), sim::Plate{rectangle(-20, -20, 20, 20), {}, {}, 0.0},
        sim::Plate{rectangle(-40, -20, 40, 20), {circle(-20, 0, 5, true)}, {}, 0.0},
        wheelPlate(12, true)}) {
    EXPECT_TRUE(slidesOf(*makePart("plate", plate)).empty());
  }
  EXPECT_TRUE(Slides().empty());
  EXPECT_TRUE(Slides(std::vector<LocalPoint>()).empty());
  // A ring stays on itself whole: nothing would tell.
  EXPECT_TRUE(
      slidesOf(*makePart("ring", {circle(0, 0, 30), {circle(0, 0, 20, true)}, {}, 0.0})).empty());
}

TEST(Slides, TheBestPlaceIsWhereTheEndsAndHolesAre) {
  const auto part = makePart("bar", slenderPlate());
  const Shot shot = shoot(sceneOf(slenderPlate(), kLie));
  const Field& field = shot.edges.fieldOf(0);
  const Eigen::Isometry3d T_part_centre = centreOf(*part, Face::kFront);
  const Eigen::Isometry3d truth = sim::poseOf(kLie) * T_part_centre;
  const double step = 1.5 * truth.translation().z() / field.focal;  // metres
  for (const double along_mm : {-20.0, -7.0, 0.0, 13.0}) {
    for (const double farther : {-0.02, 0.0, 0.02}) {
      const auto peaks =
          slidesOf(*part).peaks(field, part->radius(), slid(truth, along_mm, farther), 4);
      ASSERT_EQ(peaks.size(), 4u);
      const Eigen::Vector3d off = truth.inverse() * peaks[0].T_camera_centre.translation();
      EXPECT_LT(std::abs(off.x()), 2.0 * step) << along_mm << " " << farther;
    }
  }
}

TEST(Slides, PeaksLieApart) {
  const auto part = makePart("bar", slenderPlate());
  const Shot shot = shoot(sceneOf(slenderPlate(), kLie));
  const Eigen::Isometry3d truth = sim::poseOf(kLie) * centreOf(*part, Face::kFront);
  const Field& field = shot.edges.fieldOf(0);
  const auto peaks = slidesOf(*part).peaks(field, part->radius(), truth, 8);
  ASSERT_EQ(peaks.size(), 8u);
  for (std::size_t i = 0; i < peaks.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_FALSE(isometryNear(peaks[i].T_camera_centre, peaks[j].T_camera_centre, 1e-3, 1e-3))
          << i << " " << j;
  EXPECT_TRUE(slidesOf(*part).peaks(field, part->radius(), truth, 0).empty());
}

/// By the search about a pose: far along, a little nearer or farther, and the other way
/// round.
TEST(Slides, ABarIsFoundAlongItsLength) {
  const Parts parts{makePart("bar", slenderPlate())};
  const Shot shot = shoot(sceneOf(slenderPlate(), kLie));
  const RefineParams params;
  const Aligner aligner(shot.edges, shot.camera, params, parts);
  const Eigen::Isometry3d truth = sim::poseOf(kLie);
  for (const double along_mm : {-22.0, -9.0, 11.0, 20.0}) {
    for (const double farther : {-0.02, 0.02}) {
      for (const double turn : {0.0, M_PI}) {
        Candidate candidate = candidateNear(slid(truth, along_mm, farther));
        candidate.T_camera_part.rotate(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
        PoseHypothesis pose = aligner.alignToField(candidate);
        aligner.alignWide(&pose);
        for (int round = 0; round < 2; ++round) aligner.searchAround(&pose);
        aligner.alignNarrow(&pose);
        EXPECT_TRUE(isometryNear(pose.T_camera_part, truth, 2e-3, 4.0 * kDegrees))
            << along_mm << " " << farther << " " << turn;
      }
    }
  }
}

}  // namespace
}  // namespace planar_bin_picking
