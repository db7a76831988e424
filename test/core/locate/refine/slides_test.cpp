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

/// With edgels everywhere each place is as good: the peaks are all places that are apart, and in
/// the order of the search.
struct Spacing {
  std::size_t count;
  double along, size;  // of two neighbours, in steps of the search
};

Spacing spacingAt(double radius_px) {
  constexpr double kDepth = 0.5;
  // So slender that its long sides hold no size either.
  const auto part =
      makePart("bar", {rectangle(-60, -3, 60, 3), {circle(-50, 0, 1.5, true)}, {}, 0.0});
  Field field;
  field.focal = radius_px * kDepth / part->radius();
  field.width = static_cast<int>(3.2 * radius_px);
  field.height = static_cast<int>(0.4 * radius_px);
  field.cx = 0.5 * field.width;
  field.cy = 0.5 * field.height;
  field.distance.assign(static_cast<std::size_t>(field.width * field.height * kDirections), 0);
  const Eigen::Isometry3d T(Eigen::Translation3d(0.0, 0.0, kDepth) *
                            Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  const auto peaks = slidesOf(*part).peaks(field, part->radius(), T, 1000000);
  const double step = 1.5 / radius_px;  // radii
  Spacing out{peaks.size(), 1e9, 1e9};
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    for (const std::size_t k : {std::size_t(0), i - 1}) {
      if (k >= i) continue;
      const Eigen::Vector3d a = peaks[k].T_camera_centre.translation(),
                            b = peaks[i].T_camera_centre.translation();
      const double size = std::abs(a.z() / b.z() - 1.0) / step;
      const double along =
          std::abs((a.x() / a.z() - b.x() / b.z()) * kDepth / part->radius()) / step;
      if (along < 1.0) out.size = std::min(out.size, size);
      if (size < 1.0) out.along = std::min(out.along, along);
    }
  }
  return out;
}

TEST(Slides, AreSearchedInStepsThatSeeTheField) {
  const Spacing few = spacingAt(400.0);
  EXPECT_NEAR(few.along, 3.0, 0.3);
  EXPECT_NEAR(few.size, 3.0, 0.3);
  // In a finer field the search would take too long: its steps are longer.
  const Spacing many = spacingAt(800.0);
  EXPECT_NEAR(many.along, 4.5, 0.4);
  EXPECT_NEAR(many.size, 4.5, 0.4);
  EXPECT_NEAR(static_cast<double>(many.count), 20000.0 / 9.0, 200.0);
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
