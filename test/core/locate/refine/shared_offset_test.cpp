// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/shared_offset.h"

#include "part/visible_face.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

/// A strip of 120 x 10 mm, its edges seen `offset_mm` inside the drawn ones.
sim::Plate bevelledStrip(double offset_mm) {
  const double x = 60 - offset_mm, y = 5 - offset_mm;
  return {rectangle(-x, -y, x, y), {circle(-50, 0, 3 + offset_mm, true)}, {}, 0.0};
}

constexpr double kOffsetMm = 0.15;  // taken for tilt, 14 degrees

class SharedOffset : public testing::Test {
 protected:
  void lay(const sim::Lie& lie) {
    scene_.plates.push_back({bevelledStrip(kOffsetMm), sim::poseOf(lie)});
    lies_.push_back(sim::poseOf(lie));
  }
  /// Six that lie flat, in several directions.
  void layFlat() {
    for (int i = 0; i < 6; ++i)
      lay({130.0 * (i % 2) - 65, 55.0 * (i / 2) - 75, 600, 25.0 * i - 60});
  }
  /// Those found, in the order of the copies, from starts that are tilted about the length.
  std::vector<RefinedPose> found() const {
    std::vector<Candidate> starts;
    for (std::size_t i = 0; i < lies_.size(); ++i)
      starts.push_back(candidateNear(lies_[i], 0.0, 0.0, i % 2 == 0 ? 8.0 : -8.0));
    const Shot shot = shoot(scene_);
    const Parts parts = {makePart("strip", bevelledStrip(0.0))};
    const auto poses =
        refineCandidates(shot.edges, shot.camera, parts, starts, std::nullopt, 0.5, {}, 1);
    std::vector<RefinedPose> out;
    for (const auto& lie : lies_)
      for (const RefinedPose& p : poses)
        if ((p.T_camera_part.translation() - lie.translation()).head<2>().norm() < 5e-3)
          out.push_back(p);
    return out;
  }
  double degreesOff(const RefinedPose& pose, std::size_t copy) const {
    const Eigen::Vector3d truth = normalOf(lies_[copy], faceOf(lies_[copy]));
    return std::acos(std::min(1.0, truth.dot(normalOf(pose.T_camera_part, pose.face)))) / kDegrees;
  }
  static double sigmaDegrees(const RefinedPose& pose) {
    return std::sqrt(pose.covariance(3, 3)) / kDegrees;
  }

  sim::Scene scene_;
  std::vector<Eigen::Isometry3d> lies_;
};

TEST_F(SharedOffset, ABevelDoesNotTiltStripsThatLieFlat) {
  layFlat();
  const auto poses = found();
  ASSERT_EQ(poses.size(), 6u);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_LT(degreesOff(poses[i], i), 4.0) << i;
    EXPECT_NEAR(1e3 * poses[i].edge_offset, kOffsetMm, 0.05) << i;
  }
}

TEST_F(SharedOffset, OneThatLeansAmongThemIsNotLaidFlat) {
  layFlat();
  lay({0, 90, 600, 0, 20, 0});  // about its length
  const auto poses = found();
  ASSERT_EQ(poses.size(), 7u);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_LT(degreesOff(poses[i], i), 4.0) << i;
  }
}

TEST_F(SharedOffset, AloneAStripSaysHowUnsureItsTiltIs) {
  lay({20, 10, 600, 30});
  const auto poses = found();
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_GT(sigmaDegrees(poses[0]), 5.0);
  EXPECT_LT(degreesOff(poses[0], 0), 2.0 * sigmaDegrees(poses[0]));
}

TEST_F(SharedOffset, AloneAStripThatClearlyLeansKeepsItsTilt) {
  lay({0, 10, 600, 0, 30, 0});
  const auto poses = found();
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_LT(sigmaDegrees(poses[0]), 5.0);
  EXPECT_LT(std::min(degreesOff(poses[0], 0), std::abs(degreesOff(poses[0], 0) - 60.0)), 5.0);
}

}  // namespace
}  // namespace planar_bin_picking
